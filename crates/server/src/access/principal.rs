//! A principal: a credential that the server has checked, and the actor that the client names with it.
//!
//! The server verifies the credential and trusts the client about the actor (SPEC, WHO-1). Sessions get both in one
//! value, so other kinds of credentials need no change there.

use std::fmt;

use edit::Actor;

/// Proof of access. Only the check of the proof makes one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Credential {
    /// The server's token, which all its users share.
    SharedToken,
}

/// A credential and an actor.
#[derive(Clone, Debug)]
pub struct Principal {
    pub credential: Credential,
    /// The actor by the client's own claim.
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
