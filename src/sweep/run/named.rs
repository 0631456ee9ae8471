//! Stages under the name of their variant: several take turns in a sweep.

use crate::input::study::{Point, Study};
use crate::run::watch::RunWatch;
use crate::store::queue::QueueStanding;

/// Passes on what a variant does, its stages with its name.
pub(super) struct NamedWatch<'a> {
    pub name: &'a str,
    pub watch: &'a dyn RunWatch,
}

impl RunWatch for NamedWatch<'_> {
    fn stop(&self) -> bool {
        self.watch.stop()
    }

    fn begins(&self, study: &Study, kept: usize) {
        self.watch.begins(study, kept);
    }

    fn stage(&self, what: &str) {
        self.watch.stage(&format!("{}: {what}", self.name));
    }

    fn standing(&self, standing: &QueueStanding) {
        self.watch.standing(standing);
    }

    fn solving(&self, study: &Study, point: &Point) {
        self.watch.solving(study, point);
    }

    fn kept(&self, study: &Study, solves: usize) {
        self.watch.kept(study, solves);
    }

    fn ended(&self) {
        self.watch.ended();
    }

    fn solved(&self, study: &Study, point: &Point, failure: Option<&str>) {
        self.watch.solved(study, point, failure);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::Mutex;

    #[derive(Default)]
    struct Heard(Mutex<Vec<String>>);

    impl RunWatch for Heard {
        fn stage(&self, what: &str) {
            self.0.lock().unwrap().push(what.to_owned());
        }
    }

    #[test]
    fn a_stage_has_the_name_of_its_variant() {
        let heard = Heard::default();
        NamedWatch { name: "yellow-0.3", watch: &heard }.stage("packing realisation 4/6");
        assert_eq!(heard.0.into_inner().unwrap(), ["yellow-0.3: packing realisation 4/6"]);
    }
}
