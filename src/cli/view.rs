//! `ondine view`: arguments to a scene and a server.

use super::args::{ChangeArgs, SettingsArgs, WorkerArgs, whole};
use super::target::target_features;
use super::{Outcome, interrupt, memory};
use crate::error::Result;
use crate::scene::builtin;
use crate::scene::cache::Cache;
use crate::view::{self, Options, Source};
use clap::Args;
use std::net::{IpAddr, Ipv4Addr};

const EXAMPLES: &str = "\
Examples:
  ondine view cornell --open
  ondine view room.toml --size 1280x720
  ondine view model.glb --strategy cosine --port 8000
  ssh -L 8000:localhost:8000 HOST ondine view room.toml --port 8000      a scene of another machine

Prints the page's address, and shows the scene there until Ctrl-C. Whoever knows the address can
look and change; it is open to this machine alone, unless --listen says otherwise.
Without a page that is open nothing is rendered.";

/// Show a scene in the browser while it is rendered: move, change, compare, save
#[derive(Args, Debug)]
#[command(after_help = EXAMPLES)]
pub(super) struct ViewArgs {
    /// A scene (.toml, .gltf, .glb, .pbrt), meshes (.obj, .ply), or the name of a built-in scene (see `ondine scenes`)
    scene: String,

    /// Samples per pixel at which it ends; the page can say another number
    #[arg(long, value_name = "N", default_value_t = 16384, help_heading = "Image",
          allow_negative_numbers = true, value_parser = whole::<u32>)]
    spp: u32,
    #[command(flatten)]
    changes: ChangeArgs,
    #[command(flatten)]
    settings: SettingsArgs,

    /// The port to listen on [default: any that is free]
    #[arg(long, value_name = "P", help_heading = "Page",
          allow_negative_numbers = true, value_parser = port)]
    port: Option<u16>,
    /// The address to listen on; 0.0.0.0 lets other machines in that know the page's address
    #[arg(long, value_name = "ADDRESS", help_heading = "Page", default_value_t = IpAddr::V4(Ipv4Addr::LOCALHOST))]
    listen: IpAddr,
    /// A name that the server goes by, beside localhost and numbers; may be given several times
    #[arg(long = "host", value_name = "NAME", help_heading = "Page", value_parser = host)]
    hosts: Vec<String>,
    /// Open the page in the browser
    #[arg(long, help_heading = "Page")]
    open: bool,

    #[command(flatten)]
    workers: WorkerArgs,
}

fn port(text: &str) -> std::result::Result<u16, String> {
    super::args::within(text, 1, usize::from(u16::MAX))
        .and_then(|port| u16::try_from(port).map_err(|error| error.to_string()))
}

fn host(text: &str) -> std::result::Result<String, String> {
    let is_name = |c: char| c.is_alphanumeric() || "-._".contains(c);
    match !text.is_empty() && text.chars().all(is_name) {
        true => Ok(text.to_owned()),
        false => {
            Err("write a name alone, without port or scheme, as in render.example.org".to_owned())
        }
    }
}

pub(super) fn run(args: &ViewArgs) -> Result<Outcome> {
    let changes = args.changes.parse()?;
    let mut cache = Cache::default();
    let scene = builtin::open_changed(&args.scene, &changes, &mut cache)?;
    for warning in &scene.warnings {
        super::say(format_args!("warning: {warning}"));
    }
    let mut settings = args.settings.of(&scene);
    settings.spp = args.spp;
    let settings = args.workers.of(settings);
    settings.check()?;
    let source = Source {
        scene: args.scene.clone(),
        changes,
        cache,
        settings,
        target_features: target_features(),
        fits: |settings, images| memory::check(settings, images, "choose a smaller size"),
    };
    let options = Options {
        address: args.listen,
        port: args.port.unwrap_or(0),
        hosts: args.hosts.clone(),
    };
    let stop = interrupt::listen();
    let ready = |address: &str| {
        if let Err(error) = super::print(&format!("{address}\n")) {
            super::say(format_args!("warning: {error}"));
        }
        super::say("Ctrl-C ends it");
        if args.open
            && let Err(error) = open::that_detached(address)
        {
            super::say(format_args!("warning: no browser could be opened: {error}"));
        }
    };
    view::serve(source, scene, &options, stop, &ready)?;
    Ok(Outcome::Done)
}
