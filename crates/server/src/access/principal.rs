//! Who asks: a credential that the server has checked and, under it, the actor that the client names.
//!
//! The credential is what the server knows; the actor is what it is told, and takes at its word (SPEC, WHO-1). Sessions
//! are given both in one value, so that credentials of other kinds need no change there.

use std::fmt;

use edit::Actor;

/// What somebody has shown to be let in. Made where it is checked, and nowhere else.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Credential {
    /// The server's token, which all who may use it share.
    SharedToken,
}

/// Who asks.
#[derive(Clone, Debug)]
pub struct Principal {
    /// What the server knows of them.
    pub credential: Credential,
    /// Who they say they are.
    pub actor: Actor,
}

impl fmt::Display for Principal {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { credential, actor } = self;
        let credential = match credential {
            Credential::SharedToken => "the server's token",
        };
        write!(f, "{} ({}) with {credential}", actor.name, actor.id)
    }
}
