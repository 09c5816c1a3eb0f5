//! Who may ask for anything: this server's own page, and programs that are no browser.
//!
//! A page from elsewhere that is open in the same browser can neither read nor steer. It is known by the name that
//! it gives the server (`Host`; a forged name is how DNS rebinding begins), by where it comes from (`Origin`), and
//! by what the browser says of both (`Sec-Fetch-Site`).

use std::net::{IpAddr, SocketAddr};
use std::sync::Arc;

use axum::extract::{Request, State};
use axum::http::{HeaderName, HeaderValue, StatusCode, Version, header};
use axum::middleware::Next;
use axum::response::{IntoResponse, Response};

use super::shared::Shared;

/// What may be loaded and reached from the page: nothing but this server.
const CONTENT_POLICY: &str = "default-src 'self'; script-src 'self' 'wasm-unsafe-eval'; \
    style-src 'self' 'unsafe-inline'; img-src 'self' data: blob:; connect-src 'self'; \
    worker-src 'self' blob:; frame-ancestors 'none'; base-uri 'none'; form-action 'none'";

/// In every answer.
const HEADERS: [(HeaderName, &str); 5] = [
    (header::CONTENT_SECURITY_POLICY, CONTENT_POLICY),
    (
        HeaderName::from_static("cross-origin-resource-policy"),
        "same-origin",
    ),
    (header::X_CONTENT_TYPE_OPTIONS, "nosniff"),
    (header::REFERRER_POLICY, "no-referrer"),
    (header::CACHE_CONTROL, "no-store"),
];

/// Says where a browser's request comes from.
const FETCH_SITE: HeaderName = HeaderName::from_static("sec-fetch-site");

/// Why a request is refused.
type Refusal = (StatusCode, &'static str);

/// Refuses what is meant for, or comes from, somewhere else.
pub(super) async fn guard(
    State(shared): State<Arc<Shared>>,
    request: Request,
    next: Next,
) -> Response {
    let mut response = match admitted(&request, shared.address) {
        Ok(()) => next.run(request).await,
        Err(refusal) => refusal.into_response(),
    };
    for (name, value) in HEADERS {
        let value = HeaderValue::from_static(value);
        response.headers_mut().insert(name, value);
    }
    response
}

/// Whether a request names this server, and comes from its page or from no page at all.
fn admitted<B>(request: &axum::http::Request<B>, address: SocketAddr) -> Result<(), Refusal> {
    if request.version() != Version::HTTP_11 {
        let why = "this server speaks HTTP/1.1";
        return Err((StatusCode::HTTP_VERSION_NOT_SUPPORTED, why));
    }
    let malformed = |why| (StatusCode::BAD_REQUEST, why);
    let host = only(request, header::HOST)?.ok_or(malformed("a request must name its host"))?;
    if let Some(named) = request.uri().authority()
        && named.as_str() != host
    {
        return Err(malformed("a request must name one host"));
    }
    let elsewhere = |why| (StatusCode::FORBIDDEN, why);
    if !is_own(host, address) {
        let why = "this server does not have that name: open it by its address";
        return Err(elsewhere(why));
    }
    let origin = only(request, header::ORIGIN)?;
    let site = only(request, FETCH_SITE)?;
    let own_page = origin.is_none_or(|origin| origin.strip_prefix("http://") == Some(host));
    let own_site = site.is_none_or(|site| ["none", "same-origin"].contains(&site));
    if !own_page || !own_site {
        let why = "another page may neither read nor steer this run: type its address to open it";
        return Err(elsewhere(why));
    }
    Ok(())
}

/// The value of a header that may be there once.
fn only<B>(request: &axum::http::Request<B>, name: HeaderName) -> Result<Option<&str>, Refusal> {
    let mut values = request.headers().get_all(name).iter();
    let value = values.next().map(|value| value.to_str().unwrap_or(""));
    match values.next() {
        None => Ok(value),
        Some(_) => Err((
            StatusCode::BAD_REQUEST,
            "Host, Origin and Sec-Fetch-Site must not be repeated",
        )),
    }
}

/// Whether `host` (with a port, if it is not 80) is an address of this server, or the name of this machine to
/// itself.
fn is_own(host: &str, address: SocketAddr) -> bool {
    let (name, port) = match host.rsplit_once(':') {
        // An IPv6 address without a port ends in a bracket.
        Some((name, port)) if !host.ends_with(']') => (name, port.parse().ok()),
        _ => (host, Some(80)),
    };
    if port != Some(address.port()) {
        return false;
    }
    let bare = name.trim_start_matches('[').trim_end_matches(']');
    match bare.parse::<IpAddr>() {
        // Bound to all addresses, any number may be this machine's: names are what is forged.
        Ok(ip) => ip == address.ip() || address.ip().is_unspecified(),
        Err(_) => {
            bare.eq_ignore_ascii_case("localhost")
                && (address.ip().is_loopback() || address.ip().is_unspecified())
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The status with which a request with these headers is refused, if it is.
    fn asked(headers: &[(&str, &str)]) -> Option<u16> {
        let mut request = axum::http::Request::builder();
        for (name, value) in headers {
            request = request.header(*name, *value);
        }
        let address = "127.0.0.1:9000".parse().unwrap();
        let refused = admitted(&request.body(()).unwrap(), address).err();
        refused.map(|(status, _)| status.as_u16())
    }

    #[test]
    fn only_its_own_page_is_admitted() {
        for host in ["127.0.0.1:9000", "localhost:9000", "LOCALHOST:9000"] {
            let own = format!("http://{host}");
            assert_eq!(asked(&[("host", host)]), None, "{host}");
            assert_eq!(asked(&[("host", host), ("origin", &own)]), None, "{host}");
        }
        for host in [
            "evil.example:9000",
            "127.0.0.1",
            "127.0.0.1:9001",
            "127.0.0.1.evil.example:9000",
            "127.0.0.2:9000",
            "localhost.:9000",
            "",
        ] {
            assert_eq!(asked(&[("host", host)]), Some(403), "{host}");
        }
        let host = ("host", "127.0.0.1:9000");
        for origin in [
            "http://evil.example",
            "https://127.0.0.1:9000",
            "http://127.0.0.1:9001",
            "http://localhost:9000",
            "null",
        ] {
            assert_eq!(asked(&[host, ("origin", origin)]), Some(403), "{origin}");
        }
        for (site, refused) in [
            ("none", None),
            ("same-origin", None),
            ("same-site", Some(403)),
            ("cross-site", Some(403)),
            ("", Some(403)),
        ] {
            assert_eq!(asked(&[host, ("sec-fetch-site", site)]), refused, "{site}");
        }
    }

    #[test]
    fn what_says_one_thing_twice_is_refused() {
        let (host, site) = (("host", "127.0.0.1:9000"), ("sec-fetch-site", "none"));
        let origin = ("origin", "http://127.0.0.1:9000");
        assert_eq!(asked(&[host, site, origin]), None);
        assert_eq!(asked(&[]), Some(400));
        for twice in [host, site, origin] {
            assert_eq!(asked(&[host, site, origin, twice]), Some(400), "{twice:?}");
        }
        let elsewhere = axum::http::Request::builder()
            .uri("http://evil.example/")
            .header("host", "127.0.0.1:9000");
        let refused = admitted(
            &elsewhere.body(()).unwrap(),
            "127.0.0.1:9000".parse().unwrap(),
        );
        assert_eq!(refused.unwrap_err().0, StatusCode::BAD_REQUEST);
    }

    #[test]
    fn on_all_addresses_numbers_are_admitted_and_names_are_not() {
        let address = "0.0.0.0:9000".parse().unwrap();
        assert!(is_own("192.168.1.5:9000", address));
        assert!(is_own("[::1]:9000", address));
        assert!(!is_own("evil.example:9000", address));
        let six = "[::1]:9000".parse().unwrap();
        assert!(is_own("[::1]:9000", six) && !is_own("[::1]", six));
    }
}
