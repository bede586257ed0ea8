//! Many readers, slow ones, and none.

use crate::{Page, Server};
use std::path::Path;
use std::time::Duration;

#[test]
fn memory_is_flat_with_twenty_readers_of_which_one_is_stalled() {
    let server = Server::start(Path::new("."), "cornell --size 256x256 --threads 2");
    // It reads nothing any more.
    let stalled = server.open();
    let mut pages: Vec<Page> = (0..19).map(|_| server.open()).collect();
    let mut pictures = |n: usize| {
        for _ in 0..n {
            for page in &mut pages {
                page.picture(|_, _| true);
            }
        }
        (server.takes().1, pages[0].samples())
    };
    let (before, samples) = pictures(8);
    let (after, more) = pictures(12);
    // A picture has 0.4 MB: were they kept for the one that does not read, or for all, there would be 5 or 90 MB more.
    assert!(
        after < before + (3 << 20),
        "{} MB became {} MB",
        before >> 20,
        after >> 20
    );
    assert!(
        more > samples,
        "the render goes on: {samples} samples, {more}"
    );
    drop(stalled);
    assert!(server.is_well());
}

#[test]
fn a_page_that_is_closed_frees_its_render() {
    let server = Server::start(Path::new("."), "cornell --size 1024x1024 --threads 2");
    let work = |time: Duration| {
        let (before, _) = server.takes();
        std::thread::sleep(time);
        server.takes().0 - before
    };
    assert!(work(Duration::from_millis(500)) < 5, "nobody looks yet");
    let mut page = server.open();
    let mut other = server.open();
    page.wait_for_samples(16);
    let (_, full) = server.takes();
    drop(page);
    other.picture(|_, _| true);
    assert!(work(Duration::from_secs(1)) > 20, "the other still looks");
    drop(other);
    std::thread::sleep(Duration::from_millis(500));
    assert!(work(Duration::from_secs(1)) < 10, "nobody looks any more");
    // Freed memory may stay the process's own, but what comes later takes no more. The film alone has 100 MB.
    for _ in 0..3 {
        let mut page = server.open();
        page.wait_for_samples(16);
        drop(page);
        std::thread::sleep(Duration::from_millis(300));
    }
    let (_, again) = server.takes();
    assert!(
        again < full + (30 << 20),
        "{} MB, then {} MB",
        full >> 20,
        again >> 20
    );
}

#[test]
fn one_page_too_many_is_told_so() {
    let server = Server::start(Path::new("."), "cornell --size 16x16 --threads 1");
    let pages: Vec<Page> = (0..64).map(|_| server.open()).collect();
    let reason = server.refused();
    assert_eq!(reason, "64 pages are open already, close one");
    drop(pages);
    std::thread::sleep(Duration::from_secs(1));
    server.open();
}

#[test]
fn all_pages_see_one_view() {
    let server = Server::start(Path::new("."), "cornell --size 32x32 --threads 1");
    let (mut one, mut other) = (server.open(), server.open());
    let mut view = one.view.clone();
    view["sides"][0]["strategy"] = "cosine".into();
    one.look(&view);
    other.wait("the view of the other", |page| page.view == view);
    assert_eq!(server.open().hello["start"], one.hello["start"]);
    let mut third = server.open();
    third.wait("the view as it is", |page| page.view == view);
}

#[test]
fn paused_is_paused_and_shown_to_all() {
    let server = Server::start(Path::new("."), "cornell --size 32x32 --threads 1");
    let mut page = server.open();
    page.wait_for_samples(32);
    page.say(&serde_json::json!({"type": "pause", "paused": true}));
    page.wait("a pause", |page| page.stats["state"] == "paused");
    let samples = page.samples();
    let before = server.takes().0;
    std::thread::sleep(Duration::from_secs(1));
    assert!(server.takes().0 - before < 5);
    // Who comes later gets the picture as it is.
    let mut late = server.open();
    late.picture(|_, _| true);
    late.wait("the state", |page| page.stats["state"] == "paused");
    page.say(&serde_json::json!({"type": "pause", "paused": false}));
    page.wait("more", |page| page.samples() > samples);
}
