//! The server's only secret: a client with the token may use the server.

use std::fs::{self, File};
use std::io::{self, Write};
use std::path::Path;

use subtle::ConstantTimeEq;

use super::principal::Credential;
use crate::ServerError;

/// 128 random bits, stored in the data folder, so pages stay signed in over a restart.
#[derive(Clone)]
pub struct Token([u8; DIGITS]);

const DIGITS: usize = 32;
/// Name of the token's file in the data folder.
pub const TOKEN_FILE: &str = "token";

impl Token {
    /// Reads the token from a file, or makes it at the first start. Only the owner can read the file, which is there as
    /// a whole or not at all.
    pub(crate) fn from_file(path: &Path) -> Result<Self, ServerError> {
        let unusable = |reason| ServerError::Data { path: path.into(), reason };
        match fs::read_to_string(path) {
            Ok(text) => Self::parse(text.trim()).ok_or_else(|| ServerError::BadToken(path.into())),
            Err(error) if error.kind() == io::ErrorKind::NotFound => {
                let token = Self::parse(&random_digits().map_err(unusable)?).expect("32 digits");
                token.write(path).map_err(unusable)?;
                Ok(token)
            }
            Err(error) => Err(unusable(error)),
        }
    }

    /// Writes a temporary file and renames it. Only the owner can read temporary files.
    fn write(&self, path: &Path) -> io::Result<()> {
        let folder = path.parent().filter(|folder| *folder != "").unwrap_or(Path::new("."));
        let mut file = tempfile::NamedTempFile::new_in(folder)?;
        file.write_all(&self.0)?;
        file.as_file().sync_all()?;
        file.persist(path)?;
        File::open(folder)?.sync_all()
    }

    fn parse(text: &str) -> Option<Self> {
        let sound = text.bytes().all(|digit| matches!(digit, b'0'..=b'9' | b'a'..=b'f'));
        text.as_bytes().try_into().ok().filter(|_| sound).map(Self)
    }

    /// Returns the credential if `text` is the token. The time it takes reveals nothing about the position of a
    /// difference.
    pub(crate) fn verify(&self, text: &str) -> Option<Credential> {
        let is_equal: bool = self.0.as_slice().ct_eq(text.as_bytes()).into();
        is_equal.then_some(Credential::SharedToken)
    }

    /// Returns the 32 hexadecimal digits.
    pub fn digits(&self) -> &str {
        std::str::from_utf8(&self.0).expect("digits")
    }
}

/// Returns 128 random bits in hexadecimal.
pub fn random_digits() -> io::Result<String> {
    let mut bytes = [0; DIGITS / 2];
    getrandom::fill(&mut bytes).map_err(io::Error::from)?;
    Ok(format!("{:032x}", u128::from_be_bytes(bytes)))
}

#[cfg(test)]
mod tests {
    use std::os::unix::fs::PermissionsExt;

    use super::*;

    fn in_folder(folder: &Path) -> Result<Token, ServerError> {
        Token::from_file(&folder.join(TOKEN_FILE))
    }

    #[test]
    fn a_token_stays_over_a_restart_and_is_its_owners_alone() {
        let folder = tempfile::tempdir().unwrap();
        let first = in_folder(folder.path()).unwrap();
        assert!(in_folder(folder.path()).unwrap().verify(first.digits()).is_some());
        let mode = fs::metadata(folder.path().join(TOKEN_FILE)).unwrap().permissions().mode();
        assert_eq!(mode & 0o777, 0o600);
        let other = in_folder(tempfile::tempdir().unwrap().path()).unwrap();
        assert_eq!(other.verify(first.digits()), None);
        assert_eq!([first.verify(""), first.verify(&first.digits()[1..])], [None, None]);
    }

    #[test]
    fn a_file_that_is_no_token_is_refused() {
        let folder = tempfile::tempdir().unwrap();
        fs::write(folder.path().join(TOKEN_FILE), "secret").unwrap();
        assert!(matches!(in_folder(folder.path()), Err(ServerError::BadToken(_))));
    }

    #[test]
    fn a_token_is_in_the_configured_file() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("secret");
        let first = Token::from_file(&path).unwrap();
        assert_eq!(fs::read_to_string(&path).unwrap(), first.digits());
        let own = format!("{:032x}", 7);
        fs::write(&path, format!("{own}\n")).unwrap();
        assert_eq!(Token::from_file(&path).unwrap().digits(), own, "of somebody's own, with a line's end");
        let nowhere = Token::from_file(&folder.path().join("none/secret")).err().expect("no folder").to_string();
        assert!(nowhere.contains("none/secret"), "{nowhere}");
    }
}
