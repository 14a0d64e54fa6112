//! Who may ask: the names that the server answers to, the token, and who somebody is that has shown it.

mod hosts;
mod principal;
mod token;

pub use hosts::{Hosts, PublicUrl};
pub use principal::{Credential, Principal};
pub use token::{Token, random_digits};
