//! A server for one user on this machine: HTTP on the loopback address, for clients that know a random token.
//!
//! Any page that the user has open can send requests to a port of this machine. So a request is answered only if
//!
//! - its path begins with the token, 128 random bits that are part of the address printed by host-sim;
//! - its `Host` is a loopback name (a foreign page whose domain resolves to 127.0.0.1 sends its own domain);
//! - its `Origin`, if it has one, is a page of a loopback name.
//!
//! The port in `Host` and `Origin` may be any: `ssh -L 8888:127.0.0.1:PORT` gives the page another one. Any other
//! request gets a 403 that says why, and its connection is closed. Headers and bodies are limited in size and time,
//! and a client that reads nothing of its reply is disconnected. When too many connections have not shown the token, a
//! new one closes the oldest, so that they cannot keep out the user.

use super::lock;
use anyhow::{Context, Result};
use http_body_util::{BodyExt, Full, Limited};
use hyper::body::{Bytes, Incoming};
use hyper::header::{CONNECTION, HOST, HeaderName, HeaderValue, IF_MATCH, ORIGIN};
use hyper::server::conn::http1;
use hyper::service::service_fn;
use hyper::{Method, Response, StatusCode};
use hyper_util::rt::{TokioIo, TokioTimer};
use std::collections::BTreeMap;
use std::convert::Infallible;
use std::net::{Ipv4Addr, TcpListener};
use std::sync::{Arc, Mutex, MutexGuard};
use std::time::Duration;
use tokio::task::AbortHandle;
use tokio_io_timeout::TimeoutStream;

/// Largest number of open connections that have not shown the token.
const MAX_STRANGERS: usize = 128;
/// Time limit for a client to send a header or a body.
const PATIENCE: Duration = Duration::from_secs(10);
/// Longest time for which a client may read nothing of a reply, in multiples of [`PATIENCE`].
const READING: u32 = 3;
/// Largest size of a request's body in bytes, enough for a file with the boxes of a long recording.
const MAX_BYTES: usize = 16 << 20;

/// Names of this machine in `Host` and `Origin`.
const LOOPBACK: [&str; 3] = ["127.0.0.1", "localhost", "[::1]"];

/// Headers of every reply: a browser must not keep it, show it in another page, or let another page read it.
const HEADERS: [(&str, &str); 6] = [
    ("cache-control", "no-store"),
    ("x-content-type-options", "nosniff"),
    ("referrer-policy", "no-referrer"),
    ("cross-origin-resource-policy", "same-origin"),
    ("cross-origin-opener-policy", "same-origin"),
    (
        "content-security-policy",
        "default-src 'none'; script-src 'self'; style-src 'self' 'unsafe-inline'; img-src 'self' data: blob:; connect-src 'self'; \
         base-uri 'none'; form-action 'none'; frame-ancestors 'none'",
    ),
];

/// A request that has passed the checks of [`Door`].
pub(super) struct Request {
    pub posts: bool,
    /// The path behind the token, without the slash: `frames/7.jpg`. Empty for the page.
    pub path: String,
    pub query: String,
    /// Value of `If-Match`: the revision of the targets that the page has seen.
    pub revision: Option<u64>,
    pub body: Vec<u8>,
}

pub(super) struct Reply {
    pub status: u16,
    pub kind: &'static str,
    pub body: Vec<u8>,
    /// Name under which a browser saves the body.
    pub file: Option<String>,
    /// Address, below that of the request, to which a browser goes on.
    pub to: Option<&'static str>,
}

impl Reply {
    pub fn new(kind: &'static str, body: impl Into<Vec<u8>>) -> Self {
        Self { status: 200, kind, body: body.into(), file: None, to: None }
    }

    pub fn error(status: u16, said: &str) -> Self {
        Self { status, ..Self::new("text/plain; charset=utf-8", said) }
    }
}

/// A listening server; dropping it closes the port.
pub struct Server {
    listener: TcpListener,
    port: u16,
    token: String,
    patience: Duration,
}

impl Server {
    /// Binds a free port of the loopback address and draws a random token.
    pub fn bind() -> Result<Self> {
        let listener = TcpListener::bind((Ipv4Addr::LOCALHOST, 0)).context("cannot listen on 127.0.0.1")?;
        listener.set_nonblocking(true)?;
        let port = listener.local_addr()?.port();
        let mut token = [0; 16];
        getrandom::fill(&mut token).map_err(|error| anyhow::anyhow!("the system gives no random numbers: {error}"))?;
        let token = token.iter().map(|byte| format!("{byte:02x}")).collect();
        Ok(Self { listener, port, token, patience: PATIENCE })
    }

    pub fn address(&self) -> String {
        format!("http://127.0.0.1:{}/{}/", self.port, self.token)
    }

    /// Serves requests until the program ends. `answer` runs on a separate thread, so it may block.
    pub(super) fn run(self, answer: impl Fn(Request) -> Reply + Send + Sync + 'static) -> Result<()> {
        let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build()?;
        let (listener, patience) = (self.listener.try_clone()?, self.patience);
        let door = Arc::new(Door { server: self, answer: Box::new(answer), strangers: Mutex::default() });
        runtime.block_on(async {
            let listener = tokio::net::TcpListener::from_std(listener)?;
            for id in 0_u64.. {
                let Ok((stream, _)) = listener.accept().await else {
                    // Accepting fails while no file descriptor is free; one will be free soon.
                    tokio::time::sleep(Duration::from_millis(50)).await;
                    continue;
                };
                let mut stream = TimeoutStream::new(stream);
                stream.set_write_timeout(Some(patience * READING));
                let served = Arc::clone(&door);
                let task = tokio::spawn(async move {
                    let service = service_fn(|request| {
                        let door = Arc::clone(&served);
                        async move { Ok::<_, Infallible>(door.answered(id, request).await) }
                    });
                    let mut server = http1::Builder::new();
                    server.timer(TokioTimer::new()).header_read_timeout(patience).max_buf_size(1 << 16);
                    // A browser that disconnects is no error.
                    let _ = server.serve_connection(TokioIo::new(Box::pin(stream)), service).await;
                    served.strangers().remove(&id);
                });
                // The task cannot remove its entry before the insertion: it starts only at this thread's next `await`.
                let mut strangers = door.strangers();
                strangers.insert(id, task.abort_handle());
                if strangers.len() > MAX_STRANGERS
                    && let Some((_, oldest)) = strangers.pop_first()
                {
                    oldest.abort();
                }
            }
            Ok(())
        })
    }
}

/// Admits requests that have the token and come from this server's own page.
struct Door {
    server: Server,
    answer: Box<dyn Fn(Request) -> Reply + Send + Sync>,
    /// The connections that have not shown the token, the oldest first.
    strangers: Mutex<BTreeMap<u64, AbortHandle>>,
}

impl Door {
    fn strangers(&self) -> MutexGuard<'_, BTreeMap<u64, AbortHandle>> {
        lock(&self.strangers)
    }

    async fn answered(self: Arc<Self>, id: u64, request: hyper::Request<Incoming>) -> Response<Full<Bytes>> {
        let path = match self.entered(&request) {
            Ok(path) => path,
            Err(why) => {
                let mut refused = reply(Reply::error(403, &why));
                refused.headers_mut().insert(CONNECTION, HeaderValue::from_static("close"));
                return refused;
            }
        };
        self.strangers().remove(&id);
        let posts = match *request.method() {
            Method::GET => false,
            Method::POST => true,
            _ => return reply(Reply::error(405, "expected GET or POST")),
        };
        let query = request.uri().query().unwrap_or("").to_owned();
        let seen = request.headers().get(IF_MATCH).and_then(|value| value.to_str().ok());
        let revision = seen.and_then(|value| value.trim_matches('"').parse().ok());
        let read = Limited::new(request.into_body(), MAX_BYTES).collect();
        let body = match tokio::time::timeout(self.server.patience, read).await {
            Ok(Ok(body)) => body.to_bytes().to_vec(),
            Ok(Err(_)) => return reply(Reply::error(413, "the request has more than 16 MiB")),
            Err(_) => return reply(Reply::error(408, "the request does not end")),
        };
        let request = Request { posts, path, query, revision, body };
        let done = tokio::task::spawn_blocking(move || (self.answer)(request)).await;
        reply(done.unwrap_or_else(|_| Reply::error(500, "host-sim failed here: please report it")))
    }

    /// Returns the part of the request's path after `/TOKEN/`, or the reason why the request is refused.
    fn entered(&self, request: &hyper::Request<Incoming>) -> Result<String, String> {
        let Server { port, token, .. } = &self.server;
        let rest = request.uri().path().strip_prefix('/').and_then(|path| path.strip_prefix(token.as_str()));
        let path = rest.and_then(|rest| rest.strip_prefix('/')).ok_or_else(|| {
            "this address does not have the token of this host-sim: open the whole address that host-sim printed, with \
             the 32 letters and digits behind the port and the / at its end"
                .to_owned()
        })?;
        let header =
            |name| request.headers().get_all(name).iter().map(|value| value.to_str().unwrap_or("another name"));
        let hosts: Vec<&str> = header(HOST).collect();
        if !matches!(hosts[..], [host] if is_loopback(host)) {
            return Err(format!(
                "host-sim answers at 127.0.0.1 and localhost only, not at {}: forward the port, as by ssh -L \
                 {port}:127.0.0.1:{port}, and open http://localhost:{port}/ with the token of the printed address",
                hosts.first().unwrap_or(&"no name")
            ));
        }
        let is_own = |origin: &&str| origin.strip_prefix("http://").is_some_and(is_loopback);
        header(ORIGIN).find(|origin| !is_own(origin)).map_or_else(
            || Ok(path.to_owned()),
            |other| {
                Err(format!(
                    "host-sim answers its own page only, not a page of {other}: open the address that it printed"
                ))
            },
        )
    }
}

/// True if `authority` is a loopback name, with or without a port.
fn is_loopback(authority: &str) -> bool {
    let port = LOOPBACK.iter().find_map(|name| {
        let (host, port) = authority.split_at_checked(name.len())?;
        host.eq_ignore_ascii_case(name).then_some(port)
    });
    let is_number = |port: &str| port.parse::<u16>().is_ok() && port.bytes().all(|digit| digit.is_ascii_digit());
    port.is_some_and(|port| port.is_empty() || port.strip_prefix(':').is_some_and(is_number))
}

fn reply(Reply { status, kind, body, file, to }: Reply) -> Response<Full<Bytes>> {
    let mut response = Response::new(Full::from(body));
    *response.status_mut() = StatusCode::from_u16(status).unwrap_or(StatusCode::INTERNAL_SERVER_ERROR);
    let headers = response.headers_mut();
    headers.insert("content-type", HeaderValue::from_static(kind));
    for (name, value) in HEADERS {
        headers.insert(HeaderName::from_static(name), HeaderValue::from_static(value));
    }
    // File names need no quoting, because they contain only letters, digits and `-_.` (see `Job::name`).
    let disposition = file.and_then(|name| HeaderValue::from_str(&format!("attachment; filename=\"{name}\"")).ok());
    if let Some(disposition) = disposition {
        headers.insert("content-disposition", disposition);
    }
    if let Some(to) = to {
        headers.insert("location", HeaderValue::from_static(to));
    }
    response
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::{Read, Write};
    use std::net::{SocketAddr, TcpStream};
    use std::thread;

    /// Size in bytes of a reply that exceeds the socket buffers of any system.
    const LARGE: usize = 64 << 20;

    fn served() -> (SocketAddr, String) {
        let server = Server { patience: Duration::from_secs(1), ..Server::bind().unwrap() };
        let place = (SocketAddr::from((Ipv4Addr::LOCALHOST, server.port)), server.token.clone());
        thread::spawn(|| {
            server.run(|request| match request.path.as_str() {
                "large" => Reply::new("text/plain", vec![0; LARGE]),
                path => Reply::new("text/plain", format!("[{path}]{}", request.body.len())),
            })
        });
        place
    }

    fn asked(address: SocketAddr, text: &str) -> String {
        let mut stream = TcpStream::connect(address).unwrap();
        stream.set_read_timeout(Some(Duration::from_secs(20))).unwrap();
        stream.write_all(text.as_bytes()).unwrap();
        let mut said = Vec::new();
        // The server may close the connection early, for example after a bad header.
        let _ = stream.read_to_end(&mut said);
        String::from_utf8_lossy(&said).into_owned()
    }

    #[test]
    fn a_forwarded_port_may_have_any_number() {
        let (address, token) = served();
        let get = |host: &str, more: &str| {
            asked(
                address,
                &format!("GET /{token}/frames/7.jpg HTTP/1.1\r\nHost: {host}\r\n{more}Connection: close\r\n\r\n"),
            )
        };
        let own = address.port().to_string();
        for port in [own.as_str(), "8888", "80", "1", "65535"] {
            for name in ["127.0.0.1", "localhost", "LocalHost", "[::1]"] {
                let here = format!("{name}:{port}");
                for more in
                    [String::new(), format!("Origin: http://{here}\r\n"), format!("Origin: http://localhost:{own}\r\n")]
                {
                    let said = get(&here, &more);
                    assert!(
                        said.starts_with("HTTP/1.1 200") && said.ends_with("[frames/7.jpg]0"),
                        "{here} {more}: {said}"
                    );
                }
            }
        }
        let fine = get("localhost", "Origin: http://localhost\r\n");
        assert!(fine.starts_with("HTTP/1.1 200"), "port 80 is not written: {fine}");
        assert!(fine.contains("frame-ancestors 'none'") && fine.contains("cross-origin-resource-policy: same-origin"));
    }

    #[test]
    fn who_has_no_token_or_comes_from_elsewhere_learns_only_why() {
        let (address, token) = served();
        let port = address.port();
        let here = format!("127.0.0.1:{port}");
        let good = format!("/{token}/frames/7.jpg");
        let wrong = format!("/{}/frames/7.jpg", "0".repeat(32));
        let longer = format!("/{token}0/frames/7.jpg");
        let not_first = format!("/x/{token}/frames/7.jpg");
        let in_query = format!("/frames/7.jpg?{token}/");
        let (no_token, no_host, no_page) =
            ("does not have the token", "at 127.0.0.1 and localhost only", "its own page only");
        let paths = [
            "/",
            "/../../etc/passwd",
            "/favicon.ico",
            &good[..20],
            &good[..=32],
            &wrong,
            &longer,
            &not_first,
            &in_query,
        ];
        let tokens = paths.map(|path| (path, here.clone(), String::new(), no_token));
        let hosts = [
            "evil.example".to_owned(),
            format!("evil.example:{port}"),
            format!("127.0.0.1.evil.example:{port}"),
            format!("localhost.evil.example:{port}"),
            format!("evil.example@localhost:{port}"),
            format!("localhost:{port}@evil.example"),
            "localhost:".to_owned(),
            "localhost:+80".to_owned(),
            "localhost:65536".to_owned(),
            "127.0.0.2".to_owned(),
            "0.0.0.0".to_owned(),
            "[::2]".to_owned(),
            "::1".to_owned(),
            "\u{e9}.example".to_owned(),
        ];
        let hosts = hosts.map(|host| (good.as_str(), host, String::new(), no_host));
        let two = [(good.as_str(), here.clone(), "Host: evil.example\r\n".to_owned(), no_host)];
        let origins =
            ["http://evil.example", "null", "", "https://localhost:8888", "http://localhost.evil.example", "file://"];
        let origins = origins.map(|origin| (good.as_str(), here.clone(), format!("Origin: {origin}\r\n"), no_page));
        let all = tokens.into_iter().chain(hosts).chain(two).chain(origins);
        for ((path, host, more, why), method) in
            all.flat_map(|one| ["GET", "POST", "OPTIONS"].map(|method| (one.clone(), method)))
        {
            let said =
                asked(address, &format!("{method} {path} HTTP/1.1\r\nHost: {host}\r\n{more}Connection: close\r\n\r\n"));
            let (head, body) = said.split_once("\r\n\r\n").unwrap();
            assert!(head.starts_with("HTTP/1.1 403") && body.contains(why), "{method} {path} {host} {more}: {said}");
            assert!(!body.contains(&token) && !body.contains("[frames") && !head.contains("access-control"), "{said}");
        }
        let said = asked(address, &format!("GET {good} HTTP/1.1\r\nConnection: close\r\n\r\n"));
        assert!(said.starts_with("HTTP/1.1 403") && said.contains("not at no name"), "{said}");
    }

    #[test]
    fn what_is_too_long_or_no_request_is_refused() {
        let (address, token) = served();
        let head =
            format!("POST /{token}/targets HTTP/1.1\r\nHost: 127.0.0.1:{}\r\nConnection: close\r\n", address.port());
        let body = |length: usize| format!("{head}Content-Length: {length}\r\n\r\n{}", "x".repeat(length));
        assert!(asked(address, &body(MAX_BYTES)).ends_with(&format!("[targets]{MAX_BYTES}")));
        assert!(asked(address, &body(MAX_BYTES + 1)).starts_with("HTTP/1.1 413"));
        assert!(
            asked(address, &head.replace("POST", "DELETE").replace("\r\nConn", "\r\n\r\nConn"))
                .starts_with("HTTP/1.1 405")
        );
        assert!(asked(address, &format!("GET /{} HTTP/1.1\r\n\r\n", "x".repeat(1 << 17))).starts_with("HTTP/1.1 4"));
        assert!(asked(address, "\0\x01\x02\r\n\r\n").starts_with("HTTP/1.1 400"));
    }

    #[test]
    fn connections_without_the_token_do_not_keep_the_page_out() {
        let (address, token) = served();
        let request = |token: &str| format!("GET /{token}/ HTTP/1.1\r\nHost: 127.0.0.1:{}\r\n", address.port());
        let mut idle: Vec<_> = (0..1000).filter_map(|_| TcpStream::connect(address).ok()).collect();
        assert!(idle.len() > 500, "{}", idle.len());
        // Half of the connections send requests and read no reply.
        let many = format!("{}\r\n", request(&"0".repeat(32))).repeat(500);
        for stream in idle.iter_mut().step_by(2) {
            stream.set_nonblocking(true).unwrap();
            let _ = stream.write_all(many.as_bytes());
        }
        let begin = std::time::Instant::now();
        let get = format!("{}Connection: close\r\n\r\n", request(&token));
        assert!(asked(address, &get).starts_with("HTTP/1.1 200"));
        assert!(begin.elapsed() < Duration::from_secs(5), "{:?}", begin.elapsed());
    }

    #[test]
    fn a_connection_that_reads_nothing_ends() {
        let (address, token) = served();
        let mut stream = TcpStream::connect(address).unwrap();
        let get =
            format!("GET /{token}/large HTTP/1.1\r\nHost: 127.0.0.1:{}\r\nConnection: close\r\n\r\n", address.port());
        stream.write_all(get.as_bytes()).unwrap();
        thread::sleep(Duration::from_secs(1) * (READING + 2));
        let mut read = Vec::new();
        let _ = stream.read_to_end(&mut read);
        assert!(read.starts_with(b"HTTP/1.1 200") && read.len() < LARGE, "{}", read.len());
    }
}
