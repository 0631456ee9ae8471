//! Labels stages with the name of their variant.

use crate::run::watch::{Event, RunWatch};

/// Forwards events, with the variant's name before each stage.
pub(super) struct NamedWatch<'a> {
    /// Name of the variant; empty if it is the only one.
    pub name: &'a str,
    pub watch: &'a dyn RunWatch,
}

impl RunWatch for NamedWatch<'_> {
    fn stop(&self) -> bool {
        self.watch.stop()
    }

    fn hear(&self, event: Event) {
        match event {
            Event::Stage(what) if !self.name.is_empty() => {
                self.watch.stage(&format!("{}: {what}", self.name))
            }
            other => self.watch.hear(other),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::Mutex;

    #[derive(Default)]
    struct Heard(Mutex<Vec<String>>);

    impl RunWatch for Heard {
        fn hear(&self, event: Event) {
            self.0.lock().unwrap().push(format!("{event:?}"));
        }
    }

    #[test]
    fn a_stage_has_the_name_of_its_variant() {
        let heard = Heard::default();
        let named = NamedWatch { name: "yellow-0.3", watch: &heard };
        named.hear(Event::Stage("packing realisation 4/6"));
        named.hear(Event::Ended);
        assert_eq!(
            heard.0.into_inner().unwrap(),
            [r#"Stage("yellow-0.3: packing realisation 4/6")"#, "Ended"]
        );
    }
}
