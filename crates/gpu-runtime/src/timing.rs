//! How long the device works: its own timestamps where it has them, else the wall clock.
//!
//! Work is repeated in one submission, so that neither submitting nor waiting counts. A mark is an empty pass that
//! notes the time when all work before it is done; between marks short work is done several times, for a mark itself
//! takes a microsecond or so.

use std::time::Instant;

use serde::Serialize;

use crate::{Error, Gpu, Result};

/// Whose time it is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub enum Clock {
    /// The device's timestamps.
    Timestamps,
    /// The host's clock around whole submissions, divided by the repetitions.
    WallClock,
}

/// How long a product takes.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Timing {
    /// Median of the repetitions, milliseconds.
    pub milliseconds: f64,
    /// Bytes of the operator that a product reads, those that two dispatches read twice; vectors of light do not
    /// count.
    pub bytes_read: usize,
    /// Whose time it is.
    pub by: Clock,
}

/// Bytes of each of the buffers that are copied.
const COPIED: u64 = 128 << 20;
/// Copies that are timed.
const COPIES: u32 = 15;
/// Milliseconds from mark to mark, if that does not take more than [`MOST_BETWEEN`] times the work.
const APART: f64 = 0.3;
const MOST_BETWEEN: f64 = 32.0;
/// Submissions that the wall clock times.
const SUBMISSIONS: usize = 5;
/// Most repetitions of a submission: one less than a query set has marks.
const MOST: u32 = wgpu::QUERY_SET_MAX_QUERIES - 1;

impl Gpu {
    /// Bytes per second / 10⁹ at which the device copies from one buffer to another, what is read and what is written
    /// together: median of several copies of 128 MiB. Takes 256 MiB of the device's memory meanwhile.
    ///
    /// # Errors
    ///
    /// [`Error::Device`], also where the device has no such memory.
    pub fn copy_bandwidth(&self) -> Result<f64> {
        let size = COPIED.min(self.device.limits().max_buffer_size);
        let usage = wgpu::BufferUsages::COPY_SRC | wgpu::BufferUsages::COPY_DST;
        let [from, to] = ["copied from", "copied to"].map(|what| self.empty(what, size, usage));
        let copy = |encoder: &mut wgpu::CommandEncoder| encoder.copy_buffer_to_buffer(&from, 0, &to, 0, size);
        let (milliseconds, _) = self.time(COPIES, copy)?;
        Ok(2.0 * size as f64 / (1e6 * milliseconds))
    }

    /// Median milliseconds of `work` of `repeats` times, and whose they are.
    pub(crate) fn time(&self, repeats: u32, work: impl Fn(&mut wgpu::CommandEncoder)) -> Result<(f64, Clock)> {
        if !(1..=MOST).contains(&repeats) {
            return Err(Error::Input { what: format!("{repeats} repetitions were asked for, expected 1 to {MOST}") });
        }
        let clock = if self.has_timestamps() { Clock::Timestamps } else { Clock::WallClock };
        let times = |repeats: u32, each: u32| match clock {
            Clock::Timestamps => self.by_timestamps(repeats, each, &work),
            Clock::WallClock => self.by_wall_clock(repeats * each, &work),
        };
        // The first time, drivers do what they have put off.
        times(1, 1)?;
        let each = (APART / median(times(1, 1)?)).clamp(1.0, MOST_BETWEEN);
        Ok((median(times(repeats, each as u32)?), clock))
    }

    /// Milliseconds of `work`, which is done `each` times between two marks.
    fn by_timestamps(&self, repeats: u32, each: u32, work: impl Fn(&mut wgpu::CommandEncoder)) -> Result<Vec<f64>> {
        let count = repeats + 1;
        let descriptor = wgpu::QuerySetDescriptor { label: Some("marks"), ty: wgpu::QueryType::Timestamp, count };
        let marks = self.device.create_query_set(&descriptor);
        let size = 8 * u64::from(count);
        let usage = wgpu::BufferUsages::QUERY_RESOLVE | wgpu::BufferUsages::COPY_SRC;
        let resolved = self.empty("marks", size, usage);
        let staging = self.empty("marks read back", size, wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST);
        let mut encoder = self.encoder();
        for number in 0..count {
            if number > 0 {
                (0..each).for_each(|_| work(&mut encoder));
            }
            let timestamp_writes = Some(wgpu::ComputePassTimestampWrites {
                query_set: &marks,
                beginning_of_pass_write_index: Some(number),
                end_of_pass_write_index: None,
            });
            encoder.begin_compute_pass(&wgpu::ComputePassDescriptor { label: Some("mark"), timestamp_writes });
        }
        encoder.resolve_query_set(&marks, 0..count, &resolved, 0);
        encoder.copy_buffer_to_buffer(&resolved, 0, &staging, 0, size);
        self.submit(encoder, [&staging].into_iter())?;
        let ticks: Vec<u64> =
            self.read(&staging, |bytes| bytes.as_chunks().0.iter().map(|b| u64::from_le_bytes(*b)).collect())?;
        let milliseconds = 1e-6 * f64::from(self.queue.get_timestamp_period()) / f64::from(each);
        Ok(ticks.windows(2).map(|w| w[1].wrapping_sub(w[0]) as f64 * milliseconds).collect())
    }

    /// Milliseconds of `work`, which is done `repeats` times in a submission.
    fn by_wall_clock(&self, repeats: u32, work: impl Fn(&mut wgpu::CommandEncoder)) -> Result<Vec<f64>> {
        let submission = |_| {
            let (start, mut encoder) = (Instant::now(), self.encoder());
            (0..repeats).for_each(|_| work(&mut encoder));
            self.submit(encoder, std::iter::empty())?;
            Ok(1e3 * start.elapsed().as_secs_f64() / f64::from(repeats))
        };
        (0..SUBMISSIONS).map(submission).collect()
    }
}

fn median(mut found: Vec<f64>) -> f64 {
    found.sort_by(f64::total_cmp);
    found[found.len() / 2]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_device_counts_where_it_can_and_the_host_elsewhere() {
        if std::env::var("ALLBOUNCE_GPU").as_deref() == Ok("skip") {
            println!("gpu: skipped, ALLBOUNCE_GPU=skip");
            return;
        }
        for features in [wgpu::Features::TIMESTAMP_QUERY, wgpu::Features::empty()] {
            let gpu = Gpu::with_features(|_| true, features).expect("an adapter");
            let buffer = gpu.empty("cleared", 1 << 20, wgpu::BufferUsages::COPY_DST);
            let (milliseconds, clock) = gpu.time(3, |encoder| encoder.clear_buffer(&buffer, 0, None)).unwrap();
            assert!((0.0..1e3).contains(&milliseconds), "{milliseconds} ms");
            assert_eq!(clock == Clock::Timestamps, gpu.has_timestamps());
            assert!(clock == Clock::WallClock || !features.is_empty());
            for repeats in [0, MOST + 1] {
                let text = gpu.time(repeats, |_| ()).unwrap_err().to_string();
                assert!(text.contains(&format!("{repeats} repetitions")), "{text}");
            }
        }
    }
}
