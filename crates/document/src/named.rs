//! Lookup of lights and cameras by an id in digits or by a unique name.

use std::fmt::Display;

use light::LightId;

use crate::{CameraId, Document, EditError};

/// Maximum number of ids listed for an ambiguous name.
const MAX_LISTED_IDS: usize = 8;

impl Document {
    /// Finds a light by id or name. An id takes precedence over a name with the same digits.
    pub fn find_light(&self, called: &str) -> Result<LightId, EditError> {
        let names = self.lights().iter().map(|(id, placed)| (*id, placed.light.light().name()));
        find("light", called, names)
    }

    /// Finds a camera by id or name, as [`Self::find_light`].
    pub fn find_camera(&self, called: &str) -> Result<CameraId, EditError> {
        find("camera", called, self.cameras().iter().map(|(id, camera)| (*id, camera.name.as_str())))
    }

    /// Replaces the name in an address by the id: `/lights/key/exposure` becomes `/lights/3/exposure`. In a name `~1`
    /// stands for `/`, and `~0` for `~`, as in JSON pointers (RFC 6901). Other text stays unchanged.
    pub fn address_by_id(&self, address: &str) -> Result<String, EditError> {
        let mut parts: Vec<&str> = address.splitn(4, '/').collect();
        let ["", kind, called, _] = parts[..] else { return Ok(address.into()) };
        let called = called.replace("~1", "/").replace("~0", "~");
        let id = match kind {
            "lights" => self.find_light(&called)?.to_string(),
            "cameras" => self.find_camera(&called)?.to_string(),
            _ => return Ok(address.into()),
        };
        parts[2] = &id;
        Ok(parts.join("/"))
    }
}

fn find<'a, Id: Copy + Display>(
    what: &'static str,
    called: &str,
    names: impl Iterator<Item = (Id, &'a str)> + Clone,
) -> Result<Id, EditError> {
    if let Some((id, _)) = names.clone().find(|(id, _)| id.to_string() == called) {
        return Ok(id);
    }
    let of_name: Vec<Id> = names.filter(|(_, name)| *name == called).map(|(id, _)| id).collect();
    match of_name[..] {
        [id] => Ok(id),
        [] => Err(EditError::UnknownName { what, name: quoted_or_empty(called) }),
        _ => {
            let ids: Vec<String> = of_name.iter().take(MAX_LISTED_IDS).map(Id::to_string).collect();
            Err(EditError::AmbiguousName { what, name: quoted_or_empty(called), ids: ids.join(", ") })
        }
    }
}

fn quoted_or_empty(name: &str) -> String {
    crate::naming::quoted(name).unwrap_or_else(|| "“”".into())
}
