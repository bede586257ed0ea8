//! The live page's server, as pages and others meet it. What a browser makes of it is tested in `tests/browser`.
#![cfg(all(feature = "view", target_os = "linux"))]

mod manners;
mod pictures;
mod readers;
mod saving;

use serde_json::{Value, json};
use std::io::{BufRead, BufReader, Read, Write};
use std::net::TcpStream;
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};
use tungstenite::Message;
use tungstenite::client::IntoClientRequest;
use tungstenite::protocol::WebSocket;

/// How long anything may take before a test gives up: machines are slow when all tests run at once.
const PATIENCE: Duration = Duration::from_secs(120);

/// A server that shows a scene until dropped.
struct Server {
    child: Child,
    port: u16,
    token: String,
}

impl Server {
    fn start(folder: &Path, line: &str) -> Self {
        let mut child = Command::new(env!("CARGO_BIN_EXE_ondine"))
            .arg("view")
            .args(line.split_whitespace())
            .current_dir(folder)
            .stdout(Stdio::piped())
            .stderr(Stdio::null())
            .spawn()
            .unwrap();
        let mut address = String::new();
        let stdout = child.stdout.take().unwrap();
        BufReader::new(stdout).read_line(&mut address).unwrap();
        let rest = address.trim().strip_prefix("http://127.0.0.1:").unwrap();
        let (port, token) = rest.split_once('/').unwrap();
        Self {
            child,
            port: port.parse().unwrap(),
            token: token.trim_end_matches('/').to_owned(),
        }
    }

    fn host(&self) -> String {
        format!("127.0.0.1:{}", self.port)
    }

    /// What is answered to these bytes.
    fn raw(&self, request: &[u8]) -> Response {
        let mut stream = TcpStream::connect(("127.0.0.1", self.port)).unwrap();
        stream.set_read_timeout(Some(PATIENCE)).unwrap();
        stream.write_all(request).unwrap();
        let mut answer = Vec::new();
        stream.read_to_end(&mut answer).unwrap();
        Response::new(&answer)
    }

    /// The answer to a path below the token.
    fn get(&self, path: &str) -> Response {
        let (host, token) = (self.host(), &self.token);
        self.raw(
            format!("GET /{token}/{path} HTTP/1.1\r\nHost: {host}\r\nConnection: close\r\n\r\n")
                .as_bytes(),
        )
    }

    fn socket(&self) -> WebSocket<TcpStream> {
        let stream = TcpStream::connect(("127.0.0.1", self.port)).unwrap();
        stream.set_read_timeout(Some(PATIENCE)).unwrap();
        let url = format!("ws://{}/{}/events", self.host(), self.token);
        let mut request = url.into_client_request().unwrap();
        let origin = format!("http://{}", self.host()).parse().unwrap();
        request.headers_mut().insert("Origin", origin);
        tungstenite::client(request, stream).unwrap().0
    }

    /// Why a page that would open is closed at once.
    fn refused(&self) -> String {
        match self.socket().read().unwrap() {
            Message::Close(Some(close)) => close.reason.to_string(),
            other => panic!("{other:?}"),
        }
    }

    /// A page that is open.
    fn open(&self) -> Page {
        let socket = self.socket();
        let mut page = Page {
            socket,
            view: Value::Null,
            hello: Value::Null,
            generation: 0,
            stats: Value::Null,
        };
        page.wait("an image", |page| page.generation > 0);
        page
    }

    /// Processor time so far, hundredths of a second, and resident memory, bytes.
    fn takes(&self) -> (u64, u64) {
        let id = self.child.id();
        let stat = std::fs::read_to_string(format!("/proc/{id}/stat")).unwrap();
        let fields: Vec<&str> = stat.rsplit_once(") ").unwrap().1.split(' ').collect();
        let field = |number: usize| fields[number].parse::<u64>().unwrap();
        (field(11) + field(12), field(21) * 4096)
    }

    /// Whether it still answers.
    fn is_well(&self) -> bool {
        self.get("").code == 200
    }
}

impl Drop for Server {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

/// What is answered over HTTP.
struct Response {
    code: u16,
    head: String,
    body: Vec<u8>,
}

impl Response {
    fn new(bytes: &[u8]) -> Self {
        let end = bytes.windows(4).position(|window| window == b"\r\n\r\n");
        let end = end.unwrap_or_else(|| panic!("no answer: {}", String::from_utf8_lossy(bytes)));
        let head = String::from_utf8(bytes[..end].to_vec()).unwrap();
        Self {
            code: head[9..12].parse().unwrap(),
            body: bytes[end + 4..].to_vec(),
            head,
        }
    }

    fn header(&self, name: &str) -> Option<&str> {
        let lines = self.head.lines();
        let mut values = lines.filter_map(|line| line.split_once(": "));
        let found = values.find(|(key, _)| key.eq_ignore_ascii_case(name));
        found.map(|(_, value)| value)
    }

    fn text(&self) -> &str {
        std::str::from_utf8(&self.body).unwrap()
    }
}

/// A picture: its header, and for each side its half floats.
struct Picture {
    header: Value,
    sides: Vec<Vec<u16>>,
}

impl Picture {
    fn new(bytes: &[u8]) -> Self {
        let length = u32::from_le_bytes(bytes[..4].try_into().unwrap()) as usize;
        assert_eq!((4 + length) % 8, 0);
        let header: Value = serde_json::from_slice(&bytes[4..4 + length]).unwrap();
        let payload = &bytes[4 + length..];
        let sides = header["sides"].as_array().unwrap().iter().map(|side| {
            let number = |key: &str| side[key].as_u64().unwrap() as usize;
            let (offset, bytes) = (number("offset"), number("bytes"));
            let values = number("width") * number("height") * number("channels");
            assert_eq!((bytes, offset % 8), (values * 2, 0));
            let halves = payload[offset..offset + bytes].chunks_exact(2);
            halves
                .map(|half| u16::from_le_bytes([half[0], half[1]]))
                .collect()
        });
        Self {
            sides: sides.collect(),
            header,
        }
    }
}

/// A page that is open, and what it was told last.
struct Page {
    socket: WebSocket<TcpStream>,
    hello: Value,
    view: Value,
    generation: u64,
    stats: Value,
}

impl Page {
    fn say(&mut self, message: &Value) {
        self.socket
            .send(Message::text(message.to_string()))
            .unwrap();
    }

    /// Hears one message, and gives what else than the last state it is.
    fn hear(&mut self) -> Option<Heard> {
        match self.socket.read().unwrap() {
            Message::Binary(bytes) => {
                let picture = Picture::new(&bytes);
                self.say(&json!({"type": "drawn", "picture": picture.header["picture"]}));
                return Some(Heard::Picture(picture));
            }
            Message::Text(text) => {
                let message: Value = serde_json::from_str(&text).unwrap();
                match message["type"].as_str().unwrap() {
                    "hello" => {
                        self.view = message["start"].clone();
                        self.hello = message;
                    }
                    "view" => {
                        self.view = message["view"].clone();
                        self.generation = message["generation"].as_u64().unwrap();
                    }
                    "stats" => self.stats = message,
                    _ => return Some(Heard::Answer(message)),
                }
            }
            Message::Close(frame) => panic!("closed: {frame:?}"),
            _ => {}
        }
        None
    }

    /// Hears until something is so.
    fn wait(&mut self, what: &str, mut is_so: impl FnMut(&Page) -> bool) {
        let begin = Instant::now();
        while !is_so(self) {
            assert!(begin.elapsed() < PATIENCE, "waited for {what}");
            self.hear();
        }
    }

    /// Hears until there is such a picture.
    fn picture(&mut self, is_it: impl Fn(&Page, &Picture) -> bool) -> Picture {
        let begin = Instant::now();
        loop {
            assert!(begin.elapsed() < PATIENCE, "waited for a picture");
            match self.hear() {
                Some(Heard::Picture(picture)) if is_it(self, &picture) => return picture,
                _ => {}
            }
        }
    }

    /// The answer to a message.
    fn ask(&mut self, message: &Value) -> Value {
        self.say(message);
        let begin = Instant::now();
        loop {
            assert!(begin.elapsed() < PATIENCE, "waited for an answer");
            match self.hear() {
                Some(Heard::Answer(answer)) if answer["id"] == message["id"] => return answer,
                _ => {}
            }
        }
    }

    /// Looks at something else, which begins anew.
    fn look(&mut self, view: &Value) {
        let before = self.generation;
        self.say(&json!({"type": "view", "id": 1, "view": view}));
        let begin = Instant::now();
        while self.generation == before {
            assert!(begin.elapsed() < PATIENCE, "waited for the view");
            if let Some(Heard::Answer(answer)) = self.hear() {
                panic!("{answer}");
            }
        }
    }

    /// Hears until both sides have so many samples, if there are two.
    fn wait_for_samples(&mut self, samples: u64) {
        self.wait("samples", |page| {
            let sides = page.stats["sides"].as_array();
            page.stats["generation"] == page.generation
                && sides.is_some_and(|sides| {
                    !sides.is_empty()
                        && sides
                            .iter()
                            .all(|side| side["samples"].as_u64() >= Some(samples))
                })
        });
    }

    fn samples(&self) -> u64 {
        self.stats["sides"][0]["samples"].as_u64().unwrap_or(0)
    }
}

/// What a page hears that is no state.
enum Heard {
    Picture(Picture),
    Answer(Value),
}
