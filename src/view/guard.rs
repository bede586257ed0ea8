//! Who is let in: requests that know the token, from pages of this server alone, to a name that it goes by.

use axum::extract::{Request, State};
use axum::http::{HeaderMap, HeaderValue, StatusCode, header};
use axum::middleware::Next;
use axum::response::{IntoResponse, Response};
use std::net::IpAddr;
use std::sync::Arc;

/// What a request must know and be.
#[derive(Clone, Debug)]
pub struct Guard {
    /// The first part of every path.
    pub token: String,
    /// Whether it listens on the loopback interface alone.
    pub loopback: bool,
    /// Names that it goes by beside `localhost` and numbers.
    pub hosts: Vec<String>,
}

/// 128 random bits, as letters of an address.
///
/// # Errors
/// Where the system has no random numbers.
pub fn token() -> Result<String, getrandom::Error> {
    let mut bits = [0; 16];
    getrandom::fill(&mut bits)?;
    Ok(bits.iter().map(|byte| format!("{byte:02x}")).collect())
}

impl Guard {
    /// Why a request is refused.
    fn refuses(&self, headers: &HeaderMap, path: &str) -> Option<(StatusCode, &'static str)> {
        let host = headers
            .get(header::HOST)
            .and_then(|host| host.to_str().ok());
        // A name that somebody else's page had resolved to this machine (DNS rebinding) is none of these.
        let Some(host) = host.filter(|host| self.goes_by(name(host))) else {
            return Some((
                StatusCode::FORBIDDEN,
                "this server does not go by that name; --host NAME adds one",
            ));
        };
        let origin = headers.get(header::ORIGIN).map(|origin| origin.to_str());
        let own = |origin: &str| {
            let (scheme, rest) = origin.split_once("://").unwrap_or_default();
            ["http", "https"].contains(&scheme) && rest.eq_ignore_ascii_case(host)
        };
        if origin.is_some_and(|origin| !origin.is_ok_and(own)) {
            return Some((
                StatusCode::FORBIDDEN,
                "pages of other servers have no business here",
            ));
        }
        let token = path
            .strip_prefix('/')
            .and_then(|path| path.split('/').next());
        if !token.is_some_and(|token| same(token.as_bytes(), self.token.as_bytes())) {
            return Some((
                StatusCode::FORBIDDEN,
                "the address lacks its token; open the one that `ondine view` has printed",
            ));
        }
        None
    }

    fn goes_by(&self, name: &str) -> bool {
        let number = name.trim_start_matches('[').trim_end_matches(']');
        match number.parse::<IpAddr>() {
            Ok(address) => !self.loopback || address.is_loopback(),
            Err(_) => {
                let known = self.hosts.iter().map(String::as_str);
                std::iter::once("localhost")
                    .chain(known)
                    .any(|known| known.eq_ignore_ascii_case(name))
            }
        }
    }
}

/// A `Host` without its port.
fn name(host: &str) -> &str {
    match host.rsplit_once(':') {
        Some((name, port)) if port.bytes().all(|byte| byte.is_ascii_digit()) => name,
        _ => host,
    }
}

/// Whether two texts are equal, in a time that does not tell how far they are.
fn same(a: &[u8], b: &[u8]) -> bool {
    let differences = a.iter().zip(b).fold(0, |all, (a, b)| all | (a ^ b));
    a.len() == b.len() && differences == 0
}

/// Refuses what must not come in, and says of all that goes out that it is for this page alone.
pub async fn watch(State(guard): State<Arc<Guard>>, request: Request, next: Next) -> Response {
    let refused = guard.refuses(request.headers(), request.uri().path());
    let mut response = match refused {
        Some(refusal) => refusal.into_response(),
        None => next.run(request).await,
    };
    let headers = response.headers_mut();
    for (name, value) in [
        (
            header::CONTENT_SECURITY_POLICY,
            "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' blob: data:; connect-src 'self'; \
             base-uri 'none'; form-action 'none'; frame-ancestors 'none'",
        ),
        (header::X_CONTENT_TYPE_OPTIONS, "nosniff"),
        (header::REFERRER_POLICY, "no-referrer"),
        (header::CACHE_CONTROL, "no-store"),
    ] {
        headers.insert(name, HeaderValue::from_static(value));
    }
    response
}

#[cfg(test)]
mod tests {
    use super::*;

    fn guard(loopback: bool) -> Guard {
        Guard {
            token: "secret".to_owned(),
            loopback,
            hosts: vec!["render.example".to_owned()],
        }
    }

    fn asks(guard: &Guard, host: &str, origin: Option<&str>, path: &str) -> bool {
        let mut headers = HeaderMap::new();
        headers.insert(header::HOST, host.parse().unwrap());
        if let Some(origin) = origin {
            headers.insert(header::ORIGIN, origin.parse().unwrap());
        }
        guard.refuses(&headers, path).is_none()
    }

    #[test]
    fn its_own_page_is_let_in() {
        let guard = guard(true);
        for host in [
            "127.0.0.1:8000",
            "localhost:8000",
            "[::1]:8000",
            "render.example",
        ] {
            assert!(asks(&guard, host, None, "/secret/"), "{host}");
            let origin = format!("http://{host}");
            assert!(
                asks(&guard, host, Some(&origin), "/secret/events"),
                "{host}"
            );
        }
    }

    #[test]
    fn others_are_refused() {
        let guard = guard(true);
        let host = "127.0.0.1:8000";
        for foreign in [
            "evil.example:8000",
            "10.0.0.1:8000",
            "127.0.0.1.evil.example",
            "",
        ] {
            assert!(!asks(&guard, foreign, None, "/secret/"), "{foreign}");
        }
        for origin in [
            "http://evil.example",
            "null",
            "http://127.0.0.1:9000",
            "file://127.0.0.1:8000",
        ] {
            assert!(!asks(&guard, host, Some(origin), "/secret/"), "{origin}");
        }
        for path in [
            "/",
            "/secre/",
            "/secrets/",
            "//secret/",
            "/SECRET/",
            "secret",
            "",
        ] {
            assert!(!asks(&guard, host, None, path), "{path}");
        }
        assert!(guard.refuses(&HeaderMap::new(), "/secret/").is_some());
    }

    #[test]
    fn numbers_are_its_names_where_it_listens_to_all() {
        assert!(asks(&guard(false), "10.0.0.1:8000", None, "/secret/"));
        assert!(!asks(&guard(false), "evil.example", None, "/secret/"));
    }

    #[test]
    fn tokens_differ() {
        let (a, b) = (token().unwrap(), token().unwrap());
        assert_eq!(a.len(), 32);
        assert_ne!(a, b);
    }
}
