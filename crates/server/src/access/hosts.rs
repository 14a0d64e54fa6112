//! Host names of the server.
//!
//! A foreign page can let its own name lead to this machine, and then read the server's answers: DNS rebinding. A
//! browser tells by `Host` which name it used, and a foreign page cannot use an IP address or `localhost`.

use std::net::{IpAddr, SocketAddr};
use std::str::FromStr;

use axum::http::Uri;
use axum::http::uri::Authority;

/// An address under which browsers find the server: `https://lights.example.org`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct PublicUrl {
    /// Form that browsers use in `Origin`.
    origin: String,
    /// Host name without the port.
    name: String,
}

/// Host names that the server accepts.
#[derive(Clone, Debug)]
pub struct Hosts {
    public: Vec<PublicUrl>,
    /// True if any name is accepted: others can reach the server anyway, and no public name is configured.
    allows_any_name: bool,
}

impl Hosts {
    /// Makes the names of a server that listens on `address`.
    pub fn new(address: SocketAddr, public: &[PublicUrl]) -> Self {
        Self { allows_any_name: !address.ip().is_loopback() && public.is_empty(), public: public.to_vec() }
    }

    /// True if a request with this `Host` may be meant for the server.
    pub fn is_known_host(&self, host: &str) -> bool {
        let Ok(authority) = host.parse::<Authority>() else { return false };
        let name = authority.host();
        let address = name.trim_start_matches('[').trim_end_matches(']');
        self.allows_any_name
            || address.parse::<IpAddr>().is_ok()
            || name.eq_ignore_ascii_case("localhost")
            || self.public.iter().any(|url| name.eq_ignore_ascii_case(&url.name))
    }

    /// True if a page of this `Origin`, whose request has this `Host`, is the server's own.
    pub fn is_own_origin(&self, origin: &str, host: &str) -> bool {
        let authority = origin.strip_prefix("http://").or_else(|| origin.strip_prefix("https://"));
        authority == Some(host) || self.public.iter().any(|url| url.origin == origin)
    }
}

impl FromStr for PublicUrl {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let wrong = || format!("`{text}` is not an address of a server: write it as https://HOST or https://HOST:PORT");
        let uri: Uri = text.parse().map_err(|_| wrong())?;
        let (Some(scheme), Some(authority)) = (uri.scheme(), uri.authority()) else { return Err(wrong()) };
        let usual_port = match scheme.as_str() {
            "https" => 443,
            "http" => 80,
            _ => return Err(wrong()),
        };
        if uri.path() != "/" || uri.query().is_some() || authority.as_str().contains('@') {
            return Err(wrong());
        }
        let name = authority.host().to_ascii_lowercase();
        let port = authority.port_u16().filter(|port| *port != usual_port);
        let port = port.map(|port| format!(":{port}")).unwrap_or_default();
        Ok(Self { origin: format!("{scheme}://{name}{port}"), name })
    }
}

impl std::fmt::Display for PublicUrl {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(&self.origin)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn hosts(listen: &str, public: &[&str]) -> Hosts {
        let public: Vec<PublicUrl> = public.iter().map(|url| url.parse().unwrap()).collect();
        Hosts::new(listen.parse().unwrap(), &public)
    }

    #[test]
    fn on_loopback_only_names_that_nobody_else_can_have_lead_here() {
        let local = hosts("127.0.0.1:8080", &[]);
        for own in ["127.0.0.1:8080", "localhost", "LOCALHOST:9000", "[::1]:8080", "192.168.0.7"] {
            assert!(local.is_known_host(own), "{own}");
        }
        for foreign in ["evil.example:8080", "localhost.evil.example", "127.0.0.1.evil.example", "", "a b"] {
            assert!(!local.is_known_host(foreign), "{foreign}");
        }
        assert!(hosts("0.0.0.0:8080", &[]).is_known_host("render-3"), "others reach it under any name");
        let named = ["https://Lights.example.org/", "http://render-3:8080"];
        for listen in ["127.0.0.1:8080", "0.0.0.0:8080"] {
            let proxied = hosts(listen, &named);
            assert!(proxied.is_known_host("lights.example.org") && proxied.is_known_host("render-3:8080"));
            assert!(!proxied.is_known_host("evil.example"));
        }
    }

    #[test]
    fn pages_are_its_own_by_the_name_they_used_or_by_a_public_one() {
        let proxied = hosts("127.0.0.1:8080", &["https://lights.example.org:443"]);
        assert!(proxied.is_own_origin("http://localhost:8080", "localhost:8080"));
        assert!(proxied.is_own_origin("https://lights.example.org", "lights.example.org"));
        let by_proxy = |origin: &str| proxied.is_own_origin(origin, "127.0.0.1:8080");
        assert!(by_proxy("https://lights.example.org"), "the proxy has changed the host");
        assert!(!by_proxy("https://evil.example"));
        assert!(!by_proxy("http://lights.example.org"), "without TLS it is another origin");
        assert!(!proxied.is_own_origin("null", "localhost:8080"));
    }

    #[test]
    fn an_address_of_no_server_is_refused() {
        for text in ["", "lights", "ftp://a", "https://a/b", "https://a?b", "https://x@a", "https://"] {
            assert!(text.parse::<PublicUrl>().is_err(), "{text}");
        }
    }
}
