//! Roles of clients if other machines can reach the page: the presenter controls the run, the audience watches.

use axum::http::Uri;

/// What a client may do.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Role {
    /// Watch and control the run.
    Presenter,
    /// Watch only.
    Audience,
}

/// Keys of the roles, new at each start: part of the address, `?key=KEY`.
#[derive(Clone, Debug)]
pub(super) struct Keys {
    pub presenter: String,
    pub audience: String,
}

impl Keys {
    /// Random keys.
    pub fn new() -> Self {
        let [presenter, audience] =
            std::array::from_fn(|_| format!("{:020x}", rand::random::<u128>() >> 48));
        Self {
            presenter,
            audience,
        }
    }

    /// The role of a request; `None` without a valid key.
    pub fn role(&self, uri: &Uri) -> Option<Role> {
        let mut pairs = uri.query().unwrap_or_default().split('&');
        let key = pairs.find_map(|pair| pair.strip_prefix("key="))?;
        match key {
            key if key == self.presenter => Some(Role::Presenter),
            key if key == self.audience => Some(Role::Audience),
            _ => None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_key_gives_its_role() {
        let keys = Keys::new();
        assert!(keys.presenter != keys.audience && keys.presenter.len() == 20);
        let role = |query: &str| keys.role(&format!("/control{query}").parse().unwrap());
        assert_eq!(
            role(&format!("?key={}", keys.presenter)),
            Some(Role::Presenter)
        );
        assert_eq!(
            role(&format!("?a=b&key={}", keys.audience)),
            Some(Role::Audience)
        );
        for wrong in [
            "",
            "?key=",
            "?key=0",
            "?Key=x",
            &format!("?key={}0", keys.audience),
        ] {
            assert_eq!(role(wrong), None, "{wrong}");
        }
        assert_ne!(Keys::new().presenter, keys.presenter);
    }
}
