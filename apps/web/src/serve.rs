use std::fs::File;
use std::io::{self, Write as _};
use std::net::IpAddr;
use std::path::{Component, Path, PathBuf};

use anyhow::{anyhow, ensure};
use tiny_http::{Method, Request, Server};

/// Answers browsers with the files of a folder, until the program is stopped.
pub(crate) fn serve(folder: &Path, address: IpAddr, port: u16) -> anyhow::Result<()> {
    let index = folder.join("index.html");
    ensure!(index.is_file(), "{} isn't there: `web build FOLDER` makes a page", index.display());
    let server = Server::http((address, port))
        .map_err(|why| anyhow!("port {port} of {address}: {why}; choose another with --port"))?;
    println!("the page is at http://{} (Ctrl-C ends it)", server.server_addr());
    for request in server.incoming_requests() {
        let found =
            matches!(request.method(), Method::Get | Method::Head).then(|| file(folder, request.url())).flatten();
        // Slow readers keep nobody else waiting, and browsers that don't wait for their answer are no trouble of ours.
        std::thread::spawn(move || answer(request, found.as_deref()));
    }
    Ok(())
}

/// Sends a file, or says that there is none, and has the connection closed: of those that browsers keep open, `tiny_http`
/// takes a thread each, and now and then lets others wait until one of them is closed.
fn answer(request: Request, path: Option<&Path>) -> io::Result<()> {
    let is_head = *request.method() == Method::Head;
    let mut writer = request.into_writer();
    let Some((path, mut file)) = path.and_then(|path| Some((path, File::open(path).ok()?))) else {
        writer.write_all(b"HTTP/1.1 404 Not Found\r\nContent-Length: 0\r\nConnection: close\r\n\r\n")?;
        return writer.flush();
    };
    let (kind, length) = (content_type(path), file.metadata()?.len());
    write!(writer, "HTTP/1.1 200 OK\r\nContent-Type: {kind}\r\nContent-Length: {length}\r\nConnection: close\r\n\r\n")?;
    if !is_head {
        io::copy(&mut file, &mut writer)?;
    }
    writer.flush()
}

/// The file that a request's address means, if that is in the folder.
fn file(folder: &Path, url: &str) -> Option<PathBuf> {
    let path = url.split(['?', '#']).next()?.trim_start_matches('/');
    let path = Path::new(if path.is_empty() { "index.html" } else { path });
    let is_inside = path.components().all(|part| matches!(part, Component::Normal(_)));
    let path = folder.join(path);
    (is_inside && path.is_file()).then_some(path)
}

/// What browsers must know to run it.
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
mod tests {
    use super::*;

    #[test]
    #[allow(clippy::unwrap_used, reason = "a test may fail")]
    fn only_files_of_the_folder_are_served() {
        let folder = tempfile::tempdir().unwrap();
        let site = folder.path().join("site");
        std::fs::create_dir(&site).unwrap();
        std::fs::write(site.join("index.html"), "").unwrap();
        std::fs::write(folder.path().join("secret"), "").unwrap();
        for url in ["/", "/index.html", "/index.html?x=1", "/?x"] {
            assert_eq!(file(&site, url), Some(site.join("index.html")), "{url}");
        }
        for url in ["/../secret", "/gone", "//etc/passwd", "/..", "/index.html/../../secret"] {
            assert_eq!(file(&site, url), None, "{url}");
        }
    }
}
