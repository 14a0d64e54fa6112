//! Access: host names of the server, its token, and the principals of requests.

mod hosts;
mod principal;
mod token;

pub use hosts::{Hosts, PublicUrl};
pub use principal::{Credential, Principal};
pub use token::{TOKEN_FILE, Token, random_digits};
