//! The machine of a comparison, with the speed that makes processor seconds of several comparable.

use crate::numerics::estimate::Estimate;
use crate::numerics::fourier::PlaneFft;
use crate::run::crew::processor_seconds;
use serde::Serialize;
use std::fmt;

/// Points along each side of the plane that is transformed: a packed cell's.
const POINTS: usize = 64;
/// Samples, each of at least as many seconds: many ticks of the slowest processor clocks.
const SAMPLES: usize = 8;
const SECONDS: f64 = 0.05;
const MOST: usize = 4096;

/// Processor and calibration of a machine.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Machine {
    /// Model of the processor as the system names it, or its architecture.
    pub processor: String,
    /// Threads that the system offers.
    pub threads: usize,
    /// Forward transforms of a plane of 64 × 64 complex numbers in double precision per processor
    /// second of one thread, with the standard error; none where the system has no such clock.
    pub transforms_per_second: Option<Estimate>,
}

impl Machine {
    /// Measures the machine that this process runs on, in less than a second.
    pub fn here() -> Machine {
        let model = std::fs::read_to_string("/proc/cpuinfo").ok();
        let model = model.as_deref().and_then(|all| all.lines().find(|line| line.starts_with("model name")));
        let model = model.and_then(|line| line.split_once(": ")).map(|(_, name)| name.to_owned());
        let samples: Option<Vec<f64>> = (0..SAMPLES).map(|_| transforms_per_second()).collect();
        Machine {
            processor: model.unwrap_or_else(|| std::env::consts::ARCH.into()),
            threads: std::thread::available_parallelism().map_or(1, usize::from),
            transforms_per_second: samples.map(|samples| Estimate::of_mean(&samples)),
        }
    }
}

fn transforms_per_second() -> Option<f64> {
    let fft = PlaneFft::<f64>::new(POINTS, POINTS);
    let mut scratch = fft.scratch();
    let start = processor_seconds()?;
    let all = 0..POINTS;
    for count in 1..=MOST {
        scratch.plane.fill(1.0.into());
        fft.forward(&mut scratch, std::slice::from_ref(&all));
        let spent = processor_seconds()? - start;
        if spent >= SECONDS {
            return Some(count as f64 / spent);
        }
    }
    Some(MOST as f64 / (processor_seconds()? - start)).filter(|rate| rate.is_finite())
}

impl fmt::Display for Machine {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        write!(f, "{}, {} threads", self.processor, self.threads)?;
        let Some(rate) = &self.transforms_per_second else { return Ok(()) };
        write!(f, "; {} transforms of 64 × 64 points per processor second", rate.in_words(0))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// *Planted*: seconds per transform instead of transforms per second.
    #[test]
    fn a_machine_transforms_planes_thousands_of_times_a_second() {
        let machine = Machine::here();
        let rate = machine.transforms_per_second.expect("a processor clock");
        assert!((1e2..1e7).contains(&rate.value), "{machine}");
        assert!(machine.threads > 0 && machine.to_string().contains("transforms"), "{machine}");
    }
}
