//! A server of one folder's files, for browsers on this machine or near it.

use std::fs::File;
use std::io::{self, BufRead as _, BufReader, Read, Write};
use std::net::{IpAddr, Shutdown, SocketAddr, TcpListener, TcpStream};
use std::path::{Component, Path, PathBuf};
use std::time::{Duration, Instant};

use anyhow::{Context as _, anyhow, ensure};

/// Connections that are answered at once; others wait for one of them to end. A browser opens six.
const THREADS: usize = 32;
/// Maximum length of a request's head, in bytes.
const HEAD_BYTES: u64 = 16 << 10;
/// The longest pause of a client, and the time for a whole request.
const PATIENCE: Duration = Duration::from_secs(10);
/// The time for a whole answer, in units of the patience.
const ANSWER: u32 = 30;

/// Serves the files of a folder to browsers, until the program is stopped.
pub(crate) fn serve(folder: &Path, address: IpAddr, port: u16) -> anyhow::Result<()> {
    let index = folder.join("index.html");
    ensure!(index.is_file(), "{} isn't there: `web build FOLDER` makes a page", index.display());
    let listener = TcpListener::bind((address, port))
        .map_err(|why| anyhow!("port {port} of {address}: {why}; choose another with --port"))?;
    let folder = folder.canonicalize().with_context(|| folder.display().to_string())?;
    println!("the page is at http://{} (Ctrl-C ends it)", listener.local_addr()?);
    Site { folder, listener, patience: PATIENCE }.run(THREADS);
    Ok(())
}

struct Site {
    /// The folder's path without links.
    folder: PathBuf,
    listener: TcpListener,
    patience: Duration,
}

/// A status and the reason for it.
type Refusal = (&'static str, String);

impl Site {
    /// Answers for ever, on this number of threads.
    fn run(&self, threads: usize) {
        let answer_all = || loop {
            match self.listener.accept() {
                // Errors of clients that disconnect or are too slow are ignored.
                Ok((stream, _)) => drop(self.answer(&stream)),
                Err(_) => std::thread::sleep(Duration::from_millis(100)),
            }
        };
        std::thread::scope(|scope| (0..threads).for_each(|_| drop(scope.spawn(answer_all))));
    }

    /// Reads a request, answers it and has the connection closed.
    fn answer(&self, stream: &TcpStream) -> io::Result<()> {
        let mut client = Client { stream, pause: self.patience, until: Instant::now() + self.patience };
        let head = head(&mut client)?;
        client.until = Instant::now() + ANSWER * self.patience;
        let is_head = head.starts_with("HEAD ");
        let refusal = match self.find(&head, stream.local_addr()?) {
            Ok(path) => match File::open(&path) {
                Ok(file) => return send(&mut client, &path, file, is_head),
                Err(why) => ("404 Not Found", why.to_string()),
            },
            Err(refusal) => refusal,
        };
        let (status, why) = refusal;
        let (length, body) = (why.len(), if is_head { "" } else { why.as_str() });
        let answer = format!(
            "HTTP/1.1 {status}\r\nAllow: GET, HEAD\r\nContent-Type: text/plain; charset=utf-8\r\n\
             Content-Length: {length}\r\nConnection: close\r\n\r\n{body}"
        );
        client.write_all(answer.as_bytes())?;
        // A socket that is closed with bytes unread is reset, and the client may lose the reason.
        stream.shutdown(Shutdown::Write)?;
        client.until = Instant::now() + self.patience;
        io::copy(&mut client.take(1 << 20), &mut io::sink()).map(drop)
    }

    /// The path of the file that a request at this address asks for.
    fn find(&self, head: &str, local: SocketAddr) -> Result<PathBuf, Refusal> {
        let mut lines = head.lines();
        let words: Vec<_> = lines.next().unwrap_or_default().split(' ').collect();
        let &[method, url, "HTTP/1.0" | "HTTP/1.1"] = words.as_slice() else {
            return Err(("400 Bad Request", format!("a request of HTTP/1.1 has at most {HEAD_BYTES} bytes\n")));
        };
        let headers = lines.filter_map(|line| line.split_once(':'));
        let hosts: Vec<_> =
            headers.filter(|(name, _)| name.eq_ignore_ascii_case("host")).map(|(_, host)| host.trim()).collect();
        // Pages of other sites, whose names may temporarily resolve to this server, must not read it (DNS rebinding).
        if !matches!(hosts.as_slice(), [host] if is_own(host, local)) {
            let own = SocketAddr::new(local.ip().to_canonical(), local.port());
            return Err(("421 Misdirected Request", format!("this page is at http://{own}, and at no other name\n")));
        }
        if !matches!(method, "GET" | "HEAD") {
            return Err(("405 Method Not Allowed", "files can only be read\n".to_owned()));
        }
        self.file(url).ok_or_else(|| ("404 Not Found", "there is no such file\n".to_owned()))
    }

    /// The file that a request's address means, if that is in the folder, by links as well. Nothing is decoded: no name of
    /// the page needs it.
    fn file(&self, url: &str) -> Option<PathBuf> {
        let path = url.split(['?', '#']).next()?.strip_prefix('/')?;
        let path = Path::new(if path.is_empty() { "index.html" } else { path });
        let is_inside = path.components().all(|part| matches!(part, Component::Normal(_)));
        let path = is_inside.then(|| self.folder.join(path).canonicalize().ok())??;
        (path.starts_with(&self.folder) && path.is_file()).then_some(path)
    }
}

/// Whether a request's `Host` is this server: the address that the client reached, or this machine's own names.
fn is_own(host: &str, local: SocketAddr) -> bool {
    let port = local.port();
    let address = SocketAddr::new(local.ip().to_canonical(), port).to_string();
    let names = ["localhost", "127.0.0.1", "[::1]"].map(|name| format!("{name}:{port}"));
    names.iter().chain([&address]).any(|own| {
        // Browsers leave out HTTP's own port.
        let short = own.strip_suffix(":80").unwrap_or(own);
        host.eq_ignore_ascii_case(own) || host.eq_ignore_ascii_case(short)
    })
}

/// A request up to its empty line, or as much of it as is allowed.
fn head(client: &mut Client<'_>) -> io::Result<String> {
    let (mut head, mut lines) = (Vec::new(), BufReader::new(client.take(HEAD_BYTES)));
    while !head.ends_with(b"\r\n\r\n") {
        if lines.read_until(b'\n', &mut head)? == 0 {
            return Ok(String::new());
        }
    }
    Ok(String::from_utf8_lossy(&head).into_owned())
}

fn send(client: &mut Client<'_>, path: &Path, file: File, is_head: bool) -> io::Result<()> {
    let (kind, length) = (content_type(path), file.metadata()?.len());
    let head =
        format!("HTTP/1.1 200 OK\r\nContent-Type: {kind}\r\nContent-Length: {length}\r\nConnection: close\r\n\r\n");
    client.write_all(head.as_bytes())?;
    if !is_head {
        io::copy(&mut file.take(length), client)?;
    }
    Ok(())
}

/// A connection with a deadline and a maximum pause.
struct Client<'a> {
    stream: &'a TcpStream,
    pause: Duration,
    until: Instant,
}

impl Client<'_> {
    /// The longest wait for the next bytes. It is zero when all time is spent, which sockets refuse.
    fn wait(&self) -> Option<Duration> {
        Some(self.until.saturating_duration_since(Instant::now()).min(self.pause))
    }
}

impl Read for Client<'_> {
    fn read(&mut self, bytes: &mut [u8]) -> io::Result<usize> {
        self.stream.set_read_timeout(self.wait())?;
        self.stream.read(bytes)
    }
}

impl Write for Client<'_> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.stream.set_write_timeout(self.wait())?;
        self.stream.write(bytes)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.stream.flush()
    }
}

/// Content type by file extension, which browsers need to run a file.
fn content_type(path: &Path) -> &'static str {
    match path.extension().and_then(|end| end.to_str()) {
        Some("html") => "text/html; charset=utf-8",
        Some("js") => "text/javascript",
        Some("css") => "text/css",
        Some("wasm") => "application/wasm",
        Some("svg") => "image/svg+xml",
        _ => "application/octet-stream",
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "a test may fail")]
mod tests {
    use tempfile::TempDir;

    use super::*;

    /// A folder with a site of two files and a secret beside it, and the address where two threads serve it.
    fn site(patience: Duration) -> (TempDir, SocketAddr) {
        let folder = tempfile::tempdir().unwrap();
        let site = folder.path().join("site");
        std::fs::create_dir(&site).unwrap();
        std::fs::write(site.join("index.html"), "the page").unwrap();
        // Larger than the buffers of sockets.
        File::create(site.join("large")).unwrap().set_len(64 << 20).unwrap();
        std::fs::write(folder.path().join("secret"), "a secret").unwrap();
        #[cfg(unix)]
        for (link, to) in [("out", "../secret"), ("up", ".."), ("in", "index.html")] {
            std::os::unix::fs::symlink(to, site.join(link)).unwrap();
        }
        let listener = TcpListener::bind("127.0.0.1:0").unwrap();
        let address = listener.local_addr().unwrap();
        let site = Site { folder: site.canonicalize().unwrap(), listener, patience };
        std::thread::spawn(move || site.run(2));
        (folder, address)
    }

    fn ask(address: SocketAddr, request: &str) -> String {
        let mut stream = TcpStream::connect(address).unwrap();
        stream.set_read_timeout(Some(PATIENCE / 2)).unwrap();
        stream.write_all(request.as_bytes()).unwrap();
        let mut answer = String::new();
        stream.read_to_string(&mut answer).unwrap();
        answer
    }

    fn get(address: SocketAddr, url: &str) -> String {
        ask(address, &format!("GET {url} HTTP/1.1\r\nHost: {address}\r\n\r\n"))
    }

    #[test]
    fn only_files_of_the_folder_are_served() {
        let (_folder, address) = site(PATIENCE);
        let inside = ["/", "/index.html", "/index.html?x=1", "/?x"];
        for url in inside.into_iter().chain(cfg!(unix).then_some("/in")) {
            let answer = get(address, url);
            assert!(
                answer.starts_with("HTTP/1.1 200 OK\r\n") && answer.ends_with("\r\n\r\nthe page"),
                "{url}: {answer}"
            );
        }
        let outside =
            ["/../secret", "/%2e%2e/secret", "/..%2fsecret", "/index.html/../../secret", "//etc/passwd", "/.."];
        for url in outside.into_iter().chain(["/gone", "/out", "/up/secret", "/up", "secret", "http://localhost/"]) {
            assert!(get(address, url).starts_with("HTTP/1.1 404 "), "{url}");
        }
    }

    #[test]
    fn requests_for_other_hosts_are_refused() {
        let (_folder, address) = site(PATIENCE);
        let port = address.port();
        let status =
            |hosts: &str| ask(address, &format!("GET / HTTP/1.1\r\n{hosts}\r\n")).split(' ').nth(1).unwrap().to_owned();
        for host in ["localhost", "LocalHost", "127.0.0.1", "[::1]"] {
            assert_eq!(status(&format!("host:{host}:{port}\r\n")), "200", "{host}");
        }
        for host in
            ["elsewhere.example", "127.0.0.1.elsewhere.example", "localhost.", "192.168.0.1", "user@localhost", ""]
        {
            assert_eq!(status(&format!("Host: {host}:{port}\r\n")), "421", "{host}");
        }
        let twice = format!("Host: localhost:{port}\r\nHost: elsewhere.example\r\n");
        for hosts in ["", "Host: localhost\r\n", "Host: localhost:1\r\n", &twice] {
            assert_eq!(status(hosts), "421", "{hosts}");
        }
        let near: SocketAddr = "192.168.0.7:80".parse().unwrap();
        assert!(is_own("192.168.0.7", near) && is_own("localhost:80", near) && !is_own("192.168.0.70", near));
    }

    #[test]
    fn requests_are_small_and_only_read() {
        let (_folder, address) = site(PATIENCE);
        let answer = ask(address, &format!("HEAD / HTTP/1.1\r\nHost: {address}\r\n\r\n"));
        assert!(answer.contains("Content-Length: 8\r\n") && answer.ends_with("\r\n\r\n"), "{answer}");
        let answer = ask(address, &format!("POST / HTTP/1.1\r\nHost: {address}\r\n\r\n"));
        assert!(answer.starts_with("HTTP/1.1 405 "), "{answer}");
        let long = "x".repeat(HEAD_BYTES as usize);
        for request in [format!("GET / HTTP/1.1\r\nHost: {address}\r\nX: {long}\r\n\r\n"), "hello\r\n\r\n".to_owned()] {
            let answer = ask(address, &request);
            assert!(answer.starts_with("HTTP/1.1 400 "), "{answer}");
        }
    }

    #[test]
    fn slow_clients_keep_nobody_waiting() {
        let (_folder, address) = site(PATIENCE);
        let mut slow = TcpStream::connect(address).unwrap();
        slow.write_all(b"GET /").unwrap();
        assert!(get(address, "/").ends_with("the page"));
    }

    /// Two threads are kept busy by as many clients, until these are given up.
    #[test]
    fn slow_clients_are_given_up() {
        let patience = Duration::from_millis(100);
        let (_folder, address) = site(patience);
        let large = format!("GET /large HTTP/1.1\r\nHost: {address}\r\n\r\n");
        for said in ["", "GET / HTTP/1.1\r\nHo", &large] {
            let slow = [(); 2].map(|()| TcpStream::connect(address).unwrap());
            slow.iter().for_each(|mut slow| slow.write_all(said.as_bytes()).unwrap());
            let started = Instant::now();
            assert!(get(address, "/").ends_with("the page"), "{said}");
            assert!(started.elapsed() < ANSWER * patience, "{said}: {:?}", started.elapsed());
        }
        // One byte after the other doesn't lengthen a request's time.
        let mut slow = TcpStream::connect(address).unwrap();
        let given_up = (0..100).any(|_| {
            std::thread::sleep(patience / 4);
            slow.write_all(b"x").is_err()
        });
        assert!(given_up);
    }
}
