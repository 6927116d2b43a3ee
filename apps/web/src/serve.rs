use std::fs::File;
use std::net::IpAddr;
use std::path::{Component, Path, PathBuf};

use anyhow::{anyhow, ensure};
use tiny_http::{Header, Method, Response, Server};

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
        // Browsers that don't wait for their answer are no trouble of ours.
        let _ = match found.and_then(|path| Some((File::open(&path).ok()?, content_type(&path)))) {
            Some((file, kind)) => request.respond(Response::from_file(file).with_header(kind)),
            None => request.respond(Response::from_string("there is no such file").with_status_code(404)),
        };
    }
    Ok(())
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
fn content_type(path: &Path) -> Header {
    let kind: &[u8] = match path.extension().and_then(|end| end.to_str()) {
        Some("html") => b"text/html; charset=utf-8",
        Some("js") => b"text/javascript",
        Some("css") => b"text/css",
        Some("wasm") => b"application/wasm",
        Some("svg") => b"image/svg+xml",
        _ => b"application/octet-stream",
    };
    Header::from_bytes(&b"Content-Type"[..], kind).unwrap_or_else(|()| unreachable!("these are headers"))
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
