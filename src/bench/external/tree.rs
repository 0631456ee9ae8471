//! The processes that a program under measurement has started, with their processor time and
//! memory, as `/proc` tells them; nothing is known where there is no `/proc`.
//!
//! A process belongs to the run if its parent does, if it is in a group or session of one that
//! does, or if it has inherited the mark of the run in its environment: a daemon leaves parent,
//! group and session behind.

use std::collections::{HashMap, HashSet};

/// Variable that every process of a run inherits.
pub const MARK: &str = "INKWAVE_EXTERNAL_RUN";
/// Ticks of processor time in a second, the same on every Linux.
const TICKS: f64 = 100.0;

/// A program and all that it started.
pub struct ProcessTree {
    root: u32,
    /// The mark as it stands in an environment.
    mark: Vec<u8>,
    /// Processes of the run at the last look.
    members: HashMap<u32, Process>,
    /// Groups and sessions that only members are in.
    led: HashSet<u32>,
    /// Processes without the mark, by number and start.
    unmarked: HashSet<(u32, u64)>,
    /// Processor time of members that have ended and that no member waited for, ticks.
    ended_ticks: f64,
    /// Processor time so far, s; none without `/proc`.
    pub seconds: Option<f64>,
    /// Memory at the last look, and the most so far.
    pub bytes: f64,
    pub peak: f64,
    /// The program itself has ended, and waits to be asked how.
    pub ended: bool,
}

impl ProcessTree {
    /// The tree of a program by the number of its process and the value of its mark.
    pub fn new(root: u32, mark: &str) -> ProcessTree {
        ProcessTree {
            root,
            mark: format!("{MARK}={mark}").into_bytes(),
            members: HashMap::new(),
            led: HashSet::from([root]),
            unmarked: HashSet::new(),
            ended_ticks: 0.0,
            seconds: None,
            bytes: 0.0,
            peak: 0.0,
            ended: false,
        }
    }

    /// Takes in what has started and what has ended since the last look.
    pub fn look(&mut self) {
        let Some(root) = process(self.root) else { return };
        let entries = std::fs::read_dir("/proc").into_iter().flatten().flatten();
        let numbers = entries.filter_map(|entry| entry.file_name().to_str()?.parse().ok());
        // A process older than the program was not started by it.
        let candidates: Vec<Process> =
            numbers.filter_map(process).filter(|process| process.start >= root.start).collect();
        let before = std::mem::take(&mut self.members);
        let mut found = HashMap::from([(self.root, root)]);
        // A member may come before its parent in the list.
        loop {
            let known = found.len();
            for candidate in &candidates {
                if !found.contains_key(&candidate.number) && self.is_member(candidate, &before, &found) {
                    self.led.extend(candidate.leads());
                    found.insert(candidate.number, candidate.clone());
                }
            }
            if found.len() == known {
                break;
            }
        }
        for ended in before.values().filter(|process| !process.is_among(&found)) {
            // A parent that waits for its child takes over the child's time.
            if !before.contains_key(&ended.parent) {
                self.ended_ticks += ended.ticks;
            }
        }
        let memory: Vec<ProcessMemory> = found.keys().filter_map(|number| memory(*number)).collect();
        let ticks = self.ended_ticks + found.values().map(|process| process.ticks).sum::<f64>();
        self.seconds = Some((ticks / TICKS).max(self.seconds.unwrap_or(0.0)));
        self.bytes = memory.iter().map(|memory| memory.now).sum();
        self.peak = memory.iter().map(|memory| memory.most).sum::<f64>().max(self.peak);
        self.ended = found[&self.root].has_ended();
        self.members = found;
    }

    fn is_member(
        &mut self,
        process: &Process,
        before: &HashMap<u32, Process>,
        found: &HashMap<u32, Process>,
    ) -> bool {
        process.is_among(before)
            || found.contains_key(&process.parent)
            || self.led.contains(&process.group)
            || self.led.contains(&process.session)
            || self.is_marked(process)
    }

    fn is_marked(&mut self, process: &Process) -> bool {
        let identity = (process.number, process.start);
        if self.unmarked.contains(&identity) {
            return false;
        }
        let environment = std::fs::read(format!("/proc/{}/environ", process.number)).unwrap_or_default();
        let marked = environment.split(|byte| *byte == 0).any(|variable| variable == self.mark);
        // A process that is just replacing its program has no environment yet.
        if !marked && !environment.is_empty() {
            self.unmarked.insert(identity);
        }
        marked
    }

    /// Numbers of the processes that were still running at the last look.
    pub fn running(&self) -> Vec<u32> {
        self.members.values().filter(|process| !process.has_ended()).map(|process| process.number).collect()
    }
}

/// A line of `/proc/N/stat`.
#[derive(Clone)]
struct Process {
    number: u32,
    state: String,
    parent: u32,
    group: u32,
    session: u32,
    /// Ticks since the machine was started: with the number, a name that is never given again.
    start: u64,
    /// Its processor time and that of its children that have ended.
    ticks: f64,
}

impl Process {
    fn is_among(&self, others: &HashMap<u32, Process>) -> bool {
        others.get(&self.number).is_some_and(|other| other.start == self.start)
    }

    /// Groups and sessions that it has begun.
    fn leads(&self) -> impl Iterator<Item = u32> + use<> {
        let number = self.number;
        [self.group, self.session].into_iter().filter(move |place| *place == number)
    }

    fn has_ended(&self) -> bool {
        self.state == "Z" || self.state == "X"
    }
}

fn process(number: u32) -> Option<Process> {
    let line = std::fs::read_to_string(format!("/proc/{number}/stat")).ok()?;
    // The name, in brackets, may hold anything.
    let fields: Vec<&str> = line.rsplit_once(')')?.1.split_whitespace().collect();
    let ticks = fields.get(11..15)?.iter().filter_map(|ticks| ticks.parse::<f64>().ok()).sum();
    let number_at = |place: usize| -> Option<u32> { fields.get(place)?.parse().ok() };
    Some(Process {
        number,
        state: fields[0].into(),
        parent: number_at(1)?,
        group: number_at(2)?,
        session: number_at(3)?,
        start: fields.get(19)?.parse().ok()?,
        ticks,
    })
}

/// Memory of a process, bytes.
struct ProcessMemory {
    now: f64,
    most: f64,
}

fn memory(number: u32) -> Option<ProcessMemory> {
    let status = std::fs::read_to_string(format!("/proc/{number}/status")).ok()?;
    let bytes = |key: &str| {
        let line = status.lines().find_map(|line| line.strip_prefix(key))?;
        Some(1024.0 * line.split_whitespace().next()?.parse::<f64>().ok()?)
    };
    Some(ProcessMemory { now: bytes("VmRSS:")?, most: bytes("VmHWM:")? })
}
