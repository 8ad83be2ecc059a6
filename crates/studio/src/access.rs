//! Access: who may see the page, and who may change the scene.

use axum::http::HeaderMap;
use axum::http::header::{HOST, ORIGIN};

use crate::StudioError;

/// Permission of a viewer.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Permission {
    /// Sees and changes.
    Edit,
    /// Sees.
    Watch,
}

/// Two random words, of which one is in every address.
#[derive(Debug, Clone)]
pub struct Access {
    edit: String,
    watch: String,
    port: u16,
    read_only: bool,
}

impl Access {
    /// Draws the words.
    ///
    /// # Errors
    /// The system has no randomness.
    pub fn new(port: u16, read_only: bool) -> Result<Self, StudioError> {
        let word = || {
            let mut bytes = [0_u8; 16];
            getrandom::fill(&mut bytes).map_err(|error| StudioError::Server(error.to_string()))?;
            Ok::<String, StudioError>(bytes.iter().map(|byte| format!("{byte:02x}")).collect())
        };
        Ok(Self { edit: word()?, watch: word()?, port, read_only })
    }

    /// Returns the address for a permission.
    pub fn address(&self, permission: Permission) -> String {
        let word = if permission == Permission::Edit { &self.edit } else { &self.watch };
        format!("http://127.0.0.1:{}/{word}/", self.port)
    }

    /// Returns the permission of a request; none where it is refused.
    ///
    /// The Host must be this machine's (against names that are bound to it elsewhere). The same holds for the Origin
    /// if the browser sends one (against pages of others). `from_page` requires an Origin.
    pub fn of(&self, word: &str, headers: &HeaderMap, from_page: bool) -> Option<Permission> {
        let hosts = [format!("127.0.0.1:{}", self.port), format!("localhost:{}", self.port)];
        let text = |name| headers.get(name).map(|value| value.to_str().unwrap_or("?").to_string());
        if !text(HOST).is_some_and(|host| hosts.contains(&host)) {
            return None;
        }
        match text(ORIGIN) {
            Some(origin) if !hosts.iter().any(|host| origin == format!("http://{host}")) => return None,
            None if from_page => return None,
            _ => {}
        }
        if same(word, &self.watch) || (self.read_only && same(word, &self.edit)) {
            return Some(Permission::Watch);
        }
        same(word, &self.edit).then_some(Permission::Edit)
    }
}

/// Compares in a time that does not depend on the place of a difference.
fn same(a: &str, b: &str) -> bool {
    a.len() == b.len() && a.bytes().zip(b.bytes()).fold(0, |sum, (a, b)| sum | (a ^ b)) == 0
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    fn headers(host: &str, origin: Option<&str>) -> HeaderMap {
        let mut headers = HeaderMap::new();
        headers.insert(HOST, host.parse().unwrap());
        origin.map(|origin| headers.insert(ORIGIN, origin.parse().unwrap()));
        headers
    }

    #[test]
    fn other_hosts_origins_and_words_are_refused() {
        let access = Access::new(4000, false).unwrap();
        let granted =
            |word: &str, host: &str, origin: Option<&str>, page| access.of(word, &headers(host, origin), page);
        let edit = access.edit.clone();
        let own = Some("http://127.0.0.1:4000");
        assert_eq!(granted(&edit, "127.0.0.1:4000", None, false), Some(Permission::Edit));
        assert_eq!(granted(&edit, "localhost:4000", own, true), Some(Permission::Edit));
        assert_eq!(granted(&access.watch, "127.0.0.1:4000", own, true), Some(Permission::Watch));
        assert_eq!(granted(&edit, "127.0.0.1:4000", None, true), None, "a program without a page");
        assert_eq!(granted(&edit, "evil.example:4000", None, false), None, "a name that was bound to this machine");
        assert_eq!(granted(&edit, "127.0.0.1:4000", Some("http://evil.example"), false), None);
        assert_eq!(granted(&edit, "127.0.0.1:4000", Some("null"), false), None);
        assert_eq!(granted(&edit[1..], "127.0.0.1:4000", own, true), None);
        assert_eq!(granted("", "127.0.0.1:4000", own, true), None);
        let closed = Access::new(4000, true).unwrap();
        assert_eq!(closed.of(&closed.edit, &headers("127.0.0.1:4000", own), true), Some(Permission::Watch));
    }
}
