//! Access control: only this server's own page, and programs other than browsers, may connect.
//!
//! A foreign page in the same browser can neither read nor control the run. It is recognised by the host name
//! in its request (`Host`; DNS rebinding starts with a forged name), by its origin (`Origin`), and by the
//! browser's own statement (`Sec-Fetch-Site`).

use std::net::{IpAddr, SocketAddr};
use std::sync::Arc;

use axum::extract::{Request, State};
use axum::http::{HeaderName, HeaderValue, StatusCode, Version, header};
use axum::middleware::Next;
use axum::response::{IntoResponse, Response};

use super::roles::{Keys, Role};

/// Content security policy: the page may load and contact only this server.
const CONTENT_POLICY: &str = "default-src 'self'; script-src 'self' 'wasm-unsafe-eval'; \
    style-src 'self' 'unsafe-inline'; img-src 'self' data: blob:; connect-src 'self'; \
    worker-src 'self' blob:; frame-ancestors 'none'; base-uri 'none'; form-action 'none'";

/// Header that keeps other pages from loading what this server serves.
const RESOURCE_POLICY: HeaderName = HeaderName::from_static("cross-origin-resource-policy");
/// Header with the browser's statement about the origin of a request.
const FETCH_SITE: HeaderName = HeaderName::from_static("sec-fetch-site");

/// Paths of a run itself, which need a key if other machines can reach them, and the folder of the second run.
const KEYED: [&str; 3] = ["/control", "/views", "/sound"];
pub(super) const SECOND: &str = "/b";
/// Folder of the complete recordings, which need one, too.
const RECORDINGS: &str = "/recordings/";

/// Reason for the rejection of a request.
type Refusal = (StatusCode, &'static str);

/// Who may connect.
#[derive(Debug)]
pub(super) struct Access {
    /// Address of the server.
    pub address: SocketAddr,
    /// Keys of the roles; `None` if only this machine can reach the server.
    pub keys: Option<Keys>,
}

/// Rejects requests to other hosts and from other origins.
pub(super) async fn guard(
    State(access): State<Arc<Access>>,
    mut request: Request,
    next: Next,
) -> Response {
    let admitted = admitted(&request, access.address);
    let mut response = match admitted.and_then(|()| role(&request, access.keys.as_ref())) {
        Ok(role) => {
            request.extensions_mut().insert(role);
            next.run(request).await
        }
        Err(refusal) => refusal.into_response(),
    };
    let switches = response.status() == StatusCode::SWITCHING_PROTOCOLS;
    let mut set = |name, value| {
        let value = HeaderValue::from_static(value);
        response.headers_mut().insert(name, value);
    };
    set(header::CONTENT_SECURITY_POLICY, CONTENT_POLICY);
    set(RESOURCE_POLICY, "same-origin");
    set(header::X_CONTENT_TYPE_OPTIONS, "nosniff");
    set(header::REFERRER_POLICY, "no-referrer");
    set(header::CACHE_CONTROL, "no-store");
    if !switches {
        set(header::CONNECTION, "close");
    }
    response
}

/// The role of the client of a request. The files of the page need no key.
fn role(request: &Request, keys: Option<&Keys>) -> Result<Role, Refusal> {
    let Some(keys) = keys else {
        return Ok(Role::Presenter);
    };
    let path = request.uri().path();
    let of_run = path.strip_prefix(SECOND).unwrap_or(path);
    let needs_key = KEYED.contains(&of_run) || path.starts_with(RECORDINGS);
    match keys.role(request.uri()) {
        Some(role) => Ok(role),
        None if needs_key => Err((
            StatusCode::FORBIDDEN,
            "the key is missing or wrong; open the address with its key",
        )),
        None => Ok(Role::Audience),
    }
}

/// Checks that a request names this server and comes from its page or from no page.
fn admitted<B>(request: &axum::http::Request<B>, address: SocketAddr) -> Result<(), Refusal> {
    if request.version() != Version::HTTP_11 {
        let why = "this server supports HTTP/1.1 only";
        return Err((StatusCode::HTTP_VERSION_NOT_SUPPORTED, why));
    }
    let malformed = |why| (StatusCode::BAD_REQUEST, why);
    let host = only(request, header::HOST)?.ok_or(malformed("the Host header is missing"))?;
    if let Some(named) = request.uri().authority()
        && named.as_str() != host
    {
        return Err(malformed("Host header and URI name different hosts"));
    }
    let elsewhere = |why| (StatusCode::FORBIDDEN, why);
    if !is_own(host, address) {
        let why = "unknown host name; open the page by its IP address";
        return Err(elsewhere(why));
    }
    let origin = only(request, header::ORIGIN)?;
    let site = only(request, FETCH_SITE)?;
    let own_page = origin.is_none_or(|origin| origin.strip_prefix("http://") == Some(host));
    let own_site = site.is_none_or(|site| ["none", "same-origin"].contains(&site));
    if !own_page || !own_site {
        let why = "requests from other pages are not allowed; type the address of this page into the browser";
        return Err(elsewhere(why));
    }
    Ok(())
}

/// The value of a header that may occur at most once.
fn only<B>(request: &axum::http::Request<B>, name: HeaderName) -> Result<Option<&str>, Refusal> {
    let mut values = request.headers().get_all(name).iter();
    let value = values.next().map(|value| value.to_str().unwrap_or(""));
    match values.next() {
        None => Ok(value),
        Some(_) => Err((
            StatusCode::BAD_REQUEST,
            "Host, Origin and Sec-Fetch-Site must occur only once",
        )),
    }
}

/// Whether `host` (with a port, unless it is 80) is an address of this server or `localhost`.
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
        // A server on all interfaces accepts every IP address: only names can be forged by DNS.
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

    /// Status code with which a request with these headers is rejected, if it is.
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
    fn only_the_own_page_is_admitted() {
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
    fn repeated_headers_are_rejected() {
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
    fn on_all_interfaces_addresses_are_admitted_and_names_are_not() {
        let address = "0.0.0.0:9000".parse().unwrap();
        assert!(is_own("192.168.1.5:9000", address));
        assert!(is_own("[::1]:9000", address));
        assert!(!is_own("evil.example:9000", address));
        let six = "[::1]:9000".parse().unwrap();
        assert!(is_own("[::1]:9000", six) && !is_own("[::1]", six));
    }
}
