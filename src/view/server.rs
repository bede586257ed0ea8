//! The server: the page's files, images to be saved, and a socket for each page that is open.

use super::guard::{self, Guard};
use super::hello::Hello;
use super::look::View;
use super::picture::Picture;
use super::sides::{Sides, Source};
use super::studio::Studio;
use super::wish::{Format, Saved};
use super::{painter, reader};
use crate::error::{Error, Result};
use crate::film::tonemap::Tonemap;
use crate::render::{all_processors, workers};
use crate::scene::description::Description;
use axum::Router;
use axum::body::Body;
use axum::extract::ws::WebSocketUpgrade;
use axum::extract::{Path, Query, State};
use axum::http::{StatusCode, header};
use axum::middleware::from_fn_with_state;
use axum::response::{IntoResponse, Response};
use axum::routing::get;
use hyper::server::conn::http1;
use hyper_util::rt::{TokioIo, TokioTimer};
use hyper_util::service::TowerToHyperService;
use percent_encoding::{NON_ALPHANUMERIC, utf8_percent_encode};
use serde::Deserialize;
use std::net::{IpAddr, SocketAddr};
use std::pin::Pin;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::task::{Context, Poll};
use std::time::Duration;
use tokio::io::{AsyncRead, ReadBuf};
use tokio::sync::{Semaphore, watch};
use tokio_util::io::ReaderStream;

/// The most pages at a time.
const MOST_READERS: usize = 64;
/// The most images that are asked for at a time.
const MOST_SAVES: usize = 4;
/// The most connections at a time, beside those of pages that are open.
const MOST_CONNECTIONS: usize = 256;
/// How long a request may take to be said.
const REQUEST: Duration = Duration::from_secs(10);
/// Bytes of the longest message of a page.
const LONGEST_MESSAGE: usize = 64 << 10;
/// How often is looked whether the program is to end.
const GLANCE: Duration = Duration::from_millis(50);

/// A file of the page, embedded.
struct PageFile {
    name: &'static str,
    kind: &'static str,
    content: &'static str,
}

macro_rules! page_files {
    ($($name:literal: $kind:literal),+ $(,)?) => {
        &[$(PageFile {
            name: $name,
            kind: concat!($kind, "; charset=utf-8"),
            content: include_str!(concat!("page/", $name)),
        }),+]
    };
}

const PAGE: &[PageFile] = page_files![
    "index.html": "text/html",
    "style.css": "text/css",
    "camera.js": "text/javascript",
    "canvas.js": "text/javascript",
    "connection.js": "text/javascript",
    "controls.js": "text/javascript",
    "dom.js": "text/javascript",
    "fields.js": "text/javascript",
    "gl.js": "text/javascript",
    "lens.js": "text/javascript",
    "main.js": "text/javascript",
    "materials.js": "text/javascript",
    "picture.js": "text/javascript",
    "plot.js": "text/javascript",
    "protocol.js": "text/javascript",
    "saving.js": "text/javascript",
    "settings.js": "text/javascript",
    "statistics.js": "text/javascript",
    "tonemap.js": "text/javascript",
    "wanted.js": "text/javascript",
    "window.js": "text/javascript",
];

/// Where the page is to be had.
#[derive(Clone, Debug)]
pub struct Options {
    /// The address to listen on.
    pub address: IpAddr,
    /// The port; 0 for any that is free.
    pub port: u16,
    /// Names that the server goes by beside `localhost` and numbers.
    pub hosts: Vec<String>,
}

/// What requests share.
pub struct Server {
    /// Where the view is rendered.
    pub studio: Arc<Studio>,
    /// The last picture.
    pub pictures: watch::Receiver<Option<Picture>>,
    /// The first message to each page.
    pub hello: String,
    readers: Arc<Semaphore>,
    saves: Arc<Semaphore>,
}

/// Shows a scene until `stop`; `ready` is given the page's address once it can be opened.
///
/// # Errors
/// [`Error::Usage`] where the address cannot be listened on, the view cannot be, or threads cannot be started.
pub fn serve(
    source: Source,
    scene: Description,
    options: &Options,
    stop: &AtomicBool,
    ready: &dyn Fn(&str),
) -> Result<()> {
    let threads = source.settings.threads.unwrap_or_else(all_processors);
    let pool = workers(threads)?;
    let start = View::of(&scene, &source.settings)?;
    let failed = |error: std::io::Error| Error::Usage(format!("cannot serve the page: {error}"));
    let address = SocketAddr::new(options.address, options.port);
    let listener = std::net::TcpListener::bind(address).map_err(|error| {
        let remedy = match error.kind() {
            std::io::ErrorKind::AddrNotAvailable => "--listen takes an address of this machine",
            _ => "choose another --port, or none for any that is free",
        };
        Error::Usage(format!("cannot listen on {address}: {error}; {remedy}"))
    })?;
    listener.set_nonblocking(true).map_err(failed)?;
    let address = listener.local_addr().map_err(failed)?;
    let token = guard::token()
        .map_err(|error| Error::Usage(format!("the system has no random numbers: {error}")))?;
    let guard = Guard {
        token: token.clone(),
        loopback: address.ip().is_loopback(),
        hosts: options.hosts.clone(),
    };

    let mut sides = Sides::new(source, scene, pool);
    // Whatever is wrong with the scene is said here, not in a browser.
    sides.set(&start)?;
    let hello = Hello::new(sides.original(), start.clone(), threads);
    sides.close();
    let studio = Arc::new(Studio::new(start));
    let (picture, pictures) = watch::channel(None);
    let server = Arc::new(Server {
        studio: studio.clone(),
        pictures,
        hello: serde_json::to_string(&hello).unwrap_or_default(),
        readers: Arc::new(Semaphore::new(MOST_READERS)),
        saves: Arc::new(Semaphore::new(MOST_SAVES)),
    });
    let runtime = tokio::runtime::Builder::new_current_thread()
        .enable_all()
        .build()
        .map_err(failed)?;
    let ended = AtomicBool::new(false);
    std::thread::scope(|scope| {
        let rendering = scope.spawn(|| {
            let _says = Says(&ended);
            studio.work(sides)
        });
        scope.spawn(|| {
            let _says = Says(&ended);
            painter::work(&studio.gallery, &picture);
        });
        let served = runtime.block_on(async {
            let listener = tokio::net::TcpListener::from_std(listener)?;
            let app = router(server, guard);
            ready(&format!("http://{}/{token}/", shown(address)));
            let stopped = async {
                while !stop.load(Ordering::Relaxed) && !ended.load(Ordering::Relaxed) {
                    tokio::time::sleep(GLANCE).await;
                }
            };
            tokio::select! {
                () = accept(listener, app) => {}
                () = stopped => {}
            }
            Ok(())
        });
        studio.quit();
        let rendered = rendering.join();
        served.map_err(failed)?;
        match rendered {
            Ok(rendered) => rendered,
            Err(panic) => std::panic::resume_unwind(panic),
        }
    })
}

/// Serves whoever connects, so many at a time.
async fn accept(listener: tokio::net::TcpListener, app: Router) {
    let room = Arc::new(Semaphore::new(MOST_CONNECTIONS));
    while let Ok(permit) = room.clone().acquire_owned().await {
        let Ok((stream, _)) = listener.accept().await else {
            // Whatever the system has run out of, others may give back.
            tokio::time::sleep(GLANCE).await;
            continue;
        };
        let service = TowerToHyperService::new(app.clone());
        tokio::spawn(async move {
            let connection = http1::Builder::new()
                .timer(TokioTimer::new())
                .header_read_timeout(REQUEST)
                .serve_connection(TokioIo::new(stream), service)
                .with_upgrades();
            // Who goes away in the middle needs no answer.
            let _ = connection.await;
            drop(permit);
        });
    }
}

/// Says that a thread has ended, however it did.
struct Says<'a>(&'a AtomicBool);

impl Drop for Says<'_> {
    fn drop(&mut self) {
        self.0.store(true, Ordering::Relaxed);
    }
}

/// An address that a browser on this machine can open.
fn shown(address: SocketAddr) -> SocketAddr {
    match address.ip() {
        ip if !ip.is_unspecified() => address,
        IpAddr::V4(_) => SocketAddr::new([127, 0, 0, 1].into(), address.port()),
        IpAddr::V6(_) => SocketAddr::new(std::net::Ipv6Addr::LOCALHOST.into(), address.port()),
    }
}

fn router(server: Arc<Server>, guard: Guard) -> Router {
    // Of the token the guard has made sure.
    let name = |Path((_, name)): Path<(String, String)>| async move { file(&name) };
    Router::new()
        .route("/{token}/", get(|| async { file("index.html") }))
        .route("/{token}/{name}", get(name))
        .route("/{token}/events", get(events))
        .route("/{token}/image.exr", get(image_exr))
        .route("/{token}/image.png", get(image_png))
        .route("/{token}/command", get(command))
        .with_state(server)
        .layer(from_fn_with_state(Arc::new(guard), guard::watch))
}

fn file(name: &str) -> Response {
    match PAGE.iter().find(|file| file.name == name) {
        Some(file) => ([(header::CONTENT_TYPE, file.kind)], file.content).into_response(),
        None => (StatusCode::NOT_FOUND, "there is no such file").into_response(),
    }
}

async fn events(State(server): State<Arc<Server>>, upgrade: WebSocketUpgrade) -> Response {
    let permit = server.readers.clone().try_acquire_owned();
    upgrade
        .max_message_size(LONGEST_MESSAGE)
        .max_frame_size(LONGEST_MESSAGE)
        .on_upgrade(move |socket| async move {
            match permit {
                Ok(_permit) => reader::talk(socket, &server).await,
                // Of a refusal before there is a socket, a page would not see the reason.
                Err(_) => {
                    let why = format!("{MOST_READERS} pages are open already, close one");
                    reader::close(socket, &why).await;
                }
            }
        })
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct ImageQuery {
    #[serde(default)]
    side: usize,
    tonemap: Option<String>,
    exposure: Option<f32>,
}

impl ImageQuery {
    /// The curve and exposure; none where neither is given.
    fn tonemap(&self) -> Result<Option<Tonemap>> {
        let Self {
            tonemap, exposure, ..
        } = self;
        if tonemap.is_none() && exposure.is_none() {
            return Ok(None);
        }
        let exposure = exposure.unwrap_or(0.0);
        if !Tonemap::can_expose(exposure) {
            let message = "an exposure is a number from -64 to 64";
            return Err(Error::Usage(message.to_owned()));
        }
        let operator = tonemap.as_deref().map(str::parse).transpose()?;
        Ok(Some(Tonemap {
            operator: operator.unwrap_or_default(),
            exposure,
        }))
    }
}

async fn image_exr(State(server): State<Arc<Server>>, Query(query): Query<ImageQuery>) -> Response {
    save(&server, query.side, Format::Exr).await
}

async fn image_png(State(server): State<Arc<Server>>, Query(query): Query<ImageQuery>) -> Response {
    match query.tonemap() {
        Ok(tonemap) => {
            let format = Format::Png(tonemap.unwrap_or_default());
            save(&server, query.side, format).await
        }
        Err(error) => refusal(&error),
    }
}

async fn command(State(server): State<Arc<Server>>, Query(query): Query<ImageQuery>) -> Response {
    let tonemap = match query.tonemap() {
        Ok(tonemap) => tonemap,
        Err(error) => return refusal(&error),
    };
    match answer(server.studio.command_line(query.side, tonemap).await) {
        Ok(line) => line.into_response(),
        Err(error) => refusal(&error),
    }
}

async fn save(server: &Server, side: usize, format: Format) -> Response {
    let Ok(permit) = server.saves.clone().try_acquire_owned() else {
        let message = "other images are being saved; try again when they are";
        return (StatusCode::SERVICE_UNAVAILABLE, message).into_response();
    };
    let saved = match answer(server.studio.save(side, format).await) {
        Ok(saved) => saved,
        Err(error) => return refusal(&error),
    };
    // From here on it takes only a connection.
    drop(permit);
    let Saved {
        file,
        folder,
        name,
        command_line,
    } = saved;
    let length = file.metadata().map_or(0, |metadata| metadata.len());
    let kind = match format {
        Format::Exr => "image/x-exr",
        Format::Png(_) => "image/png",
    };
    let headers = [
        (header::CONTENT_TYPE, kind.to_owned()),
        (header::CONTENT_LENGTH, length.to_string()),
        (
            header::CONTENT_DISPOSITION,
            format!("attachment; filename=\"{name}\""),
        ),
        (
            header::HeaderName::from_static("ondine-command-line"),
            utf8_percent_encode(&command_line, NON_ALPHANUMERIC).to_string(),
        ),
    ];
    let kept = Kept {
        file: tokio::fs::File::from_std(file),
        _folder: folder,
    };
    (headers, Body::from_stream(ReaderStream::new(kept))).into_response()
}

/// A file on its way, and the folder that goes afterwards.
struct Kept {
    file: tokio::fs::File,
    _folder: Option<tempfile::TempDir>,
}

impl AsyncRead for Kept {
    fn poll_read(
        mut self: Pin<&mut Self>,
        context: &mut Context<'_>,
        buffer: &mut ReadBuf<'_>,
    ) -> Poll<std::io::Result<()>> {
        Pin::new(&mut self.file).poll_read(context, buffer)
    }
}

/// What the studio says; it says nothing where nobody is looking any more.
fn answer<T>(
    answer: std::result::Result<Result<T>, tokio::sync::oneshot::error::RecvError>,
) -> Result<T> {
    answer.unwrap_or_else(|_| {
        Err(Error::Usage(
            "no page is open, so nothing is rendered".to_owned(),
        ))
    })
}

fn refusal(error: &Error) -> Response {
    let status = match error {
        Error::Usage(_) => StatusCode::CONFLICT,
        _ => StatusCode::INTERNAL_SERVER_ERROR,
    };
    (status, error.to_string()).into_response()
}
