//! A page that is open: what it says, and what it is told.

use super::look::View;
use super::server::Server;
use super::studio::Current;
use super::wish::Picked;
use crate::error::Result;
use axum::extract::ws::{CloseFrame, Message, WebSocket, close_code};
use serde::{Deserialize, Serialize};
use std::time::Duration;
use tokio::sync::oneshot::{Receiver, error::RecvError};
use tokio::time::{Instant, MissedTickBehavior, interval, timeout};

/// A page that takes longer for a message, or from which nothing is heard for so long, is gone.
const PATIENCE: Duration = Duration::from_secs(60);
/// How often it is asked whether it is still there.
const PING: Duration = Duration::from_secs(20);

/// What a page says.
#[derive(Debug, Deserialize)]
#[serde(tag = "type", rename_all = "lowercase", deny_unknown_fields)]
enum Said {
    /// The view that it wants.
    View { id: u64, view: Box<View> },
    /// It has drawn a picture.
    Drawn { picture: u64 },
    /// What is at a pixel?
    Pick { id: u64, x: u32, y: u32 },
    /// Stop tracing, or go on.
    Pause { paused: bool },
}

/// What a page is told, beside the first message, reports and pictures.
#[derive(Serialize)]
#[serde(tag = "type", rename_all = "lowercase")]
enum Told<'a> {
    View {
        id: Option<u64>,
        generation: u64,
        view: &'a View,
    },
    Refused {
        id: u64,
        message: String,
    },
    Picked {
        id: u64,
        hit: Option<Picked>,
    },
}

/// An answer of the studio that a page waits for.
type Pending<T> = Option<(u64, Receiver<Result<T>>)>;

/// The page is gone.
struct Gone;

/// One page.
struct Reader<'a> {
    socket: WebSocket,
    server: &'a Server,
    /// The last view that it was told of.
    version: Option<u64>,
    /// The picture that it has not drawn yet.
    drawing: Option<u64>,
    view: Pending<Current>,
    pick: Pending<Option<Picked>>,
    heard: Instant,
}

/// Talks with a page until it is closed.
pub async fn talk(socket: WebSocket, server: &Server) {
    // While somebody looks, there is a render.
    let _looks = server.studio.enter();
    let mut reader = Reader {
        socket,
        server,
        version: None,
        drawing: None,
        view: None,
        pick: None,
        heard: Instant::now(),
    };
    // However it ends, it is gone.
    let _ = reader.talk().await;
}

impl Reader<'_> {
    async fn talk(&mut self) -> std::result::Result<(), Gone> {
        let server = self.server;
        let mut views = server.studio.views();
        let mut reports = server.studio.reports();
        let mut pictures = server.pictures.clone();
        views.mark_changed();
        reports.mark_changed();
        pictures.mark_changed();
        let mut ping = interval(PING);
        ping.set_missed_tick_behavior(MissedTickBehavior::Delay);
        self.send(Message::text(server.hello.clone())).await?;
        server.studio.gallery.await_picture();
        loop {
            tokio::select! {
                biased;
                said = self.socket.recv() => match said {
                    Some(Ok(message)) => self.hear(message).await?,
                    _ => return Err(Gone),
                },
                answer = answer(&mut self.view) => self.tell_view(answer).await?,
                answer = answer(&mut self.pick) => self.tell_pick(answer).await?,
                changed = views.changed() => {
                    changed.map_err(|_| Gone)?;
                    let current = views.borrow_and_update().clone();
                    if self.version != Some(current.version) {
                        self.tell_current(None, &current).await?;
                    }
                }
                changed = pictures.changed(), if self.drawing.is_none() => {
                    changed.map_err(|_| Gone)?;
                    let picture = pictures.borrow_and_update().clone();
                    if let Some(picture) = picture {
                        self.drawing = Some(picture.number);
                        self.send(Message::Binary(picture.message)).await?;
                    }
                }
                changed = reports.changed() => {
                    changed.map_err(|_| Gone)?;
                    let report = reports.borrow_and_update().clone();
                    let text = serde_json::to_string(&*report).map_err(|_| Gone)?;
                    self.send(Message::text(text)).await?;
                }
                _ = ping.tick() => {
                    if self.heard.elapsed() > PATIENCE {
                        return Err(Gone);
                    }
                    self.send(Message::Ping(Default::default())).await?;
                }
            }
        }
    }

    async fn send(&mut self, message: Message) -> std::result::Result<(), Gone> {
        match timeout(PATIENCE, self.socket.send(message)).await {
            Ok(Ok(())) => Ok(()),
            _ => Err(Gone),
        }
    }

    async fn tell(&mut self, told: &Told<'_>) -> std::result::Result<(), Gone> {
        let text = serde_json::to_string(told).map_err(|_| Gone)?;
        self.send(Message::text(text)).await
    }

    async fn tell_current(
        &mut self,
        id: Option<u64>,
        current: &Current,
    ) -> std::result::Result<(), Gone> {
        self.version = Some(current.version);
        let Current {
            generation, view, ..
        } = current;
        let generation = *generation;
        self.tell(&Told::View {
            id,
            generation,
            view,
        })
        .await
    }

    async fn tell_view(
        &mut self,
        (id, answer): (u64, std::result::Result<Result<Current>, RecvError>),
    ) -> std::result::Result<(), Gone> {
        match answer {
            Ok(Ok(current)) => self.tell_current(Some(id), &current).await,
            Ok(Err(error)) => {
                let message = error.to_string();
                self.tell(&Told::Refused { id, message }).await
            }
            // Another view came before it was begun.
            Err(_) => Ok(()),
        }
    }

    async fn tell_pick(
        &mut self,
        (id, answer): (u64, std::result::Result<Result<Option<Picked>>, RecvError>),
    ) -> std::result::Result<(), Gone> {
        match answer {
            Ok(Ok(hit)) => self.tell(&Told::Picked { id, hit }).await,
            Ok(Err(error)) => {
                let message = error.to_string();
                self.tell(&Told::Refused { id, message }).await
            }
            Err(_) => Ok(()),
        }
    }

    async fn hear(&mut self, message: Message) -> std::result::Result<(), Gone> {
        self.heard = Instant::now();
        let text = match message {
            Message::Text(text) => text,
            Message::Ping(_) | Message::Pong(_) => return Ok(()),
            Message::Binary(_) => return self.refuse("this server is told nothing in bytes").await,
            Message::Close(_) => return Err(Gone),
        };
        let said = match serde_json::from_str(&text) {
            Ok(said) => said,
            Err(error) => return self.refuse(&error.to_string()).await,
        };
        let studio = &self.server.studio;
        match said {
            Said::View { id, view } => self.view = Some((id, studio.look(*view))),
            Said::Pick { id, x, y } => self.pick = Some((id, studio.pick(x, y))),
            Said::Pause { paused } => studio.pause(paused),
            Said::Drawn { picture } => {
                if self
                    .drawing
                    .take_if(|drawing| *drawing == picture)
                    .is_some()
                {
                    studio.gallery.await_picture();
                }
            }
        }
        Ok(())
    }

    /// Ends the talk with what no page of this server would say.
    async fn refuse(&mut self, why: &str) -> std::result::Result<(), Gone> {
        self.send(goodbye(why)).await?;
        Err(Gone)
    }
}

/// Closes a page, and says why.
pub async fn close(mut socket: WebSocket, why: &str) {
    // If it does not hear it, it is gone.
    let _ = timeout(PATIENCE, socket.send(goodbye(why))).await;
}

fn goodbye(why: &str) -> Message {
    // A close frame holds 123 bytes of reason.
    let reason: String = why.chars().filter(char::is_ascii).take(120).collect();
    Message::Close(Some(CloseFrame {
        code: close_code::POLICY,
        reason: reason.into(),
    }))
}

/// The answer that is waited for; never, where none is.
async fn answer<T>(pending: &mut Pending<T>) -> (u64, std::result::Result<Result<T>, RecvError>) {
    match pending {
        Some((id, receiver)) => {
            let (id, answer) = (*id, receiver.await);
            *pending = None;
            (id, answer)
        }
        None => std::future::pending().await,
    }
}
