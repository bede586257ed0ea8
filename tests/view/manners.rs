//! Who is refused, and what is left standing.

use crate::{Page, Server};
use serde_json::json;
use std::io::{Read, Write};
use std::net::TcpStream;
use std::path::Path;
use std::process::Command;
use std::time::{Duration, Instant};
use tungstenite::Message;
use tungstenite::client::IntoClientRequest;

const TINY: &str = "cornell --size 32x32 --threads 1";

fn here() -> &'static Path {
    Path::new(".")
}

#[test]
fn the_page_and_its_files_are_served_for_this_page_alone() {
    let server = Server::start(here(), TINY);
    for (file, kind) in [
        ("", "text/html; charset=utf-8"),
        ("style.css", "text/css; charset=utf-8"),
        ("main.js", "text/javascript; charset=utf-8"),
    ] {
        let response = server.get(file);
        assert_eq!(response.code, 200, "{file}");
        assert_eq!(response.header("content-type"), Some(kind));
        let policy = response.header("content-security-policy").unwrap();
        assert!(policy.starts_with("default-src 'none'; script-src 'self'"));
        assert_eq!(response.header("referrer-policy"), Some("no-referrer"));
        assert!(!response.body.is_empty());
    }
    let page = server.get("");
    // Each file that the page names is there, and none is anywhere else.
    let files = page
        .text()
        .split('"')
        .filter(|word| word.ends_with(".js") || word.ends_with(".css"));
    assert!(
        files
            .map(|file| assert_eq!(server.get(file).code, 200, "{file}"))
            .count()
            >= 2
    );
    assert!(!page.text().contains("https://"));
}

#[test]
fn whoever_lacks_name_origin_or_token_is_refused() {
    let server = Server::start(here(), TINY);
    let (host, token) = (server.host(), server.token.clone());
    let ask = |request: String| server.raw(request.as_bytes()).code;
    let get = |path: &str, headers: &str| {
        ask(format!(
            "GET {path} HTTP/1.1\r\nConnection: close\r\n{headers}\r\n\r\n"
        ))
    };
    let mine = format!("/{token}/");
    let host_line = format!("Host: {host}");
    assert_eq!(get(&mine, &host_line), 200);
    assert_eq!(get(&mine, &format!("Host: localhost:{}", server.port)), 200);

    for foreign in [
        "evil.example",
        "evil.example:80",
        "10.1.2.3",
        "127.0.0.1.evil.example",
    ] {
        assert_eq!(get(&mine, &format!("Host: {foreign}")), 403, "{foreign}");
    }
    for origin in [
        "http://evil.example",
        "null",
        "http://127.0.0.1:1",
        "https://evil.example:443",
    ] {
        let headers = format!("{host_line}\r\nOrigin: {origin}");
        assert_eq!(get(&mine, &headers), 403, "{origin}");
        let upgrade = "Upgrade: websocket\r\nSec-WebSocket-Version: 13\r\nSec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==";
        let headers = format!("{headers}\r\n{upgrade}");
        assert_eq!(get(&format!("{mine}events"), &headers), 403, "{origin}");
    }
    let almost = &token[..token.len() - 1];
    for path in [
        "/".to_owned(),
        "/events".to_owned(),
        "/image.exr".to_owned(),
        "/index.html".to_owned(),
        format!("/{almost}/"),
        format!("/{almost}0/image.exr").replace(&token, "x"),
        format!("//{token}/"),
        format!("/%2e/{token}/"),
    ] {
        // One in sixteen tokens ends in 0.
        let expected = if path.starts_with(&mine) { 200 } else { 403 };
        assert!([expected, 409].contains(&get(&path, &host_line)), "{path}");
    }
    for path in [
        "../../etc/passwd",
        "..%2f..%2fetc%2fpasswd",
        "%2e%2e/Cargo.toml",
        "page/../main.js",
        "/etc/passwd",
        "..\\x",
        "main.js%00",
    ] {
        let code = get(&format!("{mine}{path}"), &host_line);
        assert_eq!(code, 404, "{path}");
    }
    for method in ["POST", "PUT", "DELETE", "OPTIONS"] {
        let request = format!(
            "{method} {mine} HTTP/1.1\r\n{host_line}\r\nContent-Length: 0\r\nConnection: close\r\n\r\n"
        );
        assert_eq!(ask(request), 405, "{method}");
    }
    assert!(server.is_well());
}

#[test]
fn ten_thousand_malformed_frames_change_nothing() {
    let server = Server::start(here(), TINY);
    let mut page = server.open();
    page.wait_for_samples(16);
    let view = page.view.clone();
    let whole = json!({"type": "view", "id": 1, "view": view}).to_string();
    let mut frames: Vec<Vec<u8>> = [
        "",
        "{",
        "null",
        "[]",
        "\"view\"",
        "{}",
        "{\"type\":\"viev\"}",
        "{\"type\":\"view\"}",
        "{\"type\":\"drawn\",\"picture\":-1}",
        "{\"type\":\"drawn\",\"picture\":1,\"more\":2}",
        "{\"type\":\"pause\",\"paused\":\"yes\"}",
        "{\"type\":\"pick\",\"id\":1,\"x\":1e99,\"y\":0}",
    ]
    .map(|text| frame(0x81, text.as_bytes(), text.len() as u64))
    .to_vec();
    // Truncated, of another type, not UTF-8, without a mask, longer than it says, longer than is allowed, of no kind.
    for cut in [1, 20, whole.len() / 2, whole.len() - 1] {
        frames.push(frame(0x81, &whole.as_bytes()[..cut], cut as u64));
    }
    frames.push(frame(0x82, whole.as_bytes(), whole.len() as u64));
    frames.push(frame(0x81, &[0xff, 0xfe, 0x00], 3));
    frames.push([&[0x81, 4][..], b"null"].concat());
    frames.push(frame(0x81, b"null", 3));
    frames.push(frame(0x81, b"null", 1 << 40));
    frames.push(frame(0xf3, b"null", 4));
    frames.push(frame(0x89, &[b'x'; 200], 200));
    frames.push(frame(0x81, &vec![b' '; 70_000], 70_000));
    let begin = Instant::now();
    for (sent, frame) in frames.iter().cycle().take(10_000).enumerate() {
        let mut socket = upgraded(&server);
        // It may have been closed in the middle of what is too long.
        let _ = socket.write_all(frame);
        if sent % 500 == 0 {
            // It is closed, but for frames that are still to be continued.
            socket.shutdown(std::net::Shutdown::Write).unwrap();
            socket
                .set_read_timeout(Some(Duration::from_secs(60)))
                .unwrap();
            let mut answer = Vec::new();
            let end = socket.read_to_end(&mut answer);
            assert!(
                end.is_ok() || end.is_err_and(|e| e.kind() == std::io::ErrorKind::ConnectionReset)
            );
            assert!(server.is_well());
        }
    }
    println!("{:.1} s", begin.elapsed().as_secs_f64());
    assert!(server.is_well());
    assert_eq!(page.view, view);
    let before = page.samples();
    page.wait("more samples", |page| page.samples() > before + 16);
    assert_eq!(page.generation, 1, "nothing began anew");
}

/// A masked frame of so many bytes, as it says.
fn frame(first: u8, payload: &[u8], says: u64) -> Vec<u8> {
    let mut bytes = vec![first];
    match says {
        0..126 => bytes.push(0x80 | says as u8),
        126..65536 => {
            bytes.push(0x80 | 126);
            bytes.extend((says as u16).to_be_bytes());
        }
        _ => {
            bytes.push(0x80 | 127);
            bytes.extend(says.to_be_bytes());
        }
    }
    // A mask of zeros masks nothing.
    bytes.extend([0; 4]);
    bytes.extend(payload);
    bytes
}

fn upgraded(server: &Server) -> TcpStream {
    let stream = TcpStream::connect(("127.0.0.1", server.port)).unwrap();
    stream.set_nodelay(true).unwrap();
    let url = format!("ws://{}/{}/events", server.host(), server.token);
    let (mut socket, _) = tungstenite::client(url.into_client_request().unwrap(), stream).unwrap();
    socket.get_mut().try_clone().unwrap()
}

#[test]
fn a_malformed_message_is_told_why() {
    let server = Server::start(here(), TINY);
    let mut page = server.open();
    page.say(&json!({"type": "view", "id": 1, "view": {"size": [1, 1]}}));
    let close = loop {
        if let Message::Close(close) = page.socket.read().unwrap() {
            break close.unwrap();
        }
    };
    assert_eq!(u16::from(close.code), 1008);
    assert!(close.reason.contains("missing field"), "{}", close.reason);
}

#[test]
fn what_cannot_be_looked_at_is_refused_with_a_reason_and_the_view_stays() {
    let server = Server::start(here(), TINY);
    let mut page = server.open();
    page.wait_for_samples(16);
    let start = page.view.clone();
    let mut refused = |pointer: &str, value: serde_json::Value, reason: &str| {
        let mut view = start.clone();
        *view
            .pointer_mut(pointer)
            .unwrap_or_else(|| panic!("{pointer}")) = value;
        let answer = page.ask(&json!({"type": "view", "id": 7, "view": view}));
        assert_eq!(answer["type"], "refused", "{pointer}");
        let message = answer["message"].as_str().unwrap();
        assert!(message.contains(reason), "{pointer}: {message}");
        assert!(!message.contains('\n'), "{message}");
    };
    refused("/size", json!([0, 32]), "the width is 0");
    refused("/size", json!([32, 70000]), "the height is 70000");
    refused("/size", json!([65535, 65535]), "need about");
    refused("/camera", json!("back"), "has no camera \"back\"");
    refused(
        "/lens/look_at",
        start["lens"]["position"].clone(),
        "same point",
    );
    refused("/lens/up", json!([0, 0, 1]), "parallel");
    refused("/lens/vertical_fov", json!(180), "vertical_fov");
    refused("/lens/aperture_radius", json!(-1), "aperture_radius");
    refused("/lens/focus_distance", json!(0), "focus_distance");
    refused("/sides", json!([]), "0 sides");
    refused(
        "/sides/0/strategy",
        json!("best"),
        "unknown strategy \"best\"",
    );
    refused(
        "/sides/0/sampler",
        json!("dice"),
        "unknown sampler \"dice\"",
    );
    refused("/sides/0/path_length", json!(0), "the path length is 0");
    refused("/layer", json!("depth"), "not recorded");
    refused("/limit", json!(0), "spp");
    refused(
        "/materials",
        json!({"wood": {"type": "glass", "ior": 1.5}}),
        "no material \"wood\"",
    );
    refused("/materials", json!({"white": {"type": "wood"}}), "wood");
    refused(
        "/materials",
        json!({"white": {"type": "lambert", "albedo": [2, 2, 2]}}),
        "albedo",
    );
    refused(
        "/materials",
        json!({"white": {"type": "lambert", "albedo": [0.5, 0.5, 0.5], "\n": 3}}),
        "has no \"\\n\"",
    );
    let answer = page.ask(&json!({"type": "pick", "id": 8, "x": 32, "y": 0}));
    assert_eq!(answer["type"], "refused");
    assert_eq!((page.view.clone(), page.generation), (start, 1));
    let before = page.samples();
    page.wait("more samples", |page| page.samples() > before);
}

#[test]
fn ctrl_c_ends_it_and_a_port_that_is_taken_is_told() {
    let mut server = Server::start(here(), TINY);
    let mut page: Page = server.open();
    page.wait_for_samples(16);
    let taken = Command::new(env!("CARGO_BIN_EXE_ondine"))
        .args(["view", "cornell", "--port", &server.port.to_string()])
        .output()
        .unwrap();
    assert_eq!(taken.status.code(), Some(2));
    let message = String::from_utf8(taken.stderr).unwrap();
    assert!(message.contains("cannot listen on 127.0.0.1:"), "{message}");
    assert!(message.contains("--port"), "{message}");

    let id = server.child.id().to_string();
    assert!(
        Command::new("kill")
            .args(["-INT", &id])
            .status()
            .unwrap()
            .success()
    );
    let begin = Instant::now();
    while server.child.try_wait().unwrap().is_none() {
        assert!(begin.elapsed() < Duration::from_secs(20), "it does not end");
        std::thread::sleep(Duration::from_millis(10));
    }
    assert_eq!(server.child.wait().unwrap().code(), Some(0));
}
