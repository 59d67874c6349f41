//! Zones in the profiler Tracy, with the feature `tracy`: one for each timed frame on the host, and one for each of its
//! passes on the device. Without the feature, this module does nothing.

use ssct::gpu::FrameReport;

/// Draws zones in the profiler; empty without the feature.
pub struct Zones {
    #[cfg(feature = "tracy")]
    client: tracy_client::Client,
    #[cfg(feature = "tracy")]
    device: Option<tracy_client::GpuContext>,
    /// The moment from which timestamps count.
    #[cfg(feature = "tracy")]
    begun: std::time::Instant,
    /// The end of the last pass that was drawn, in nanoseconds since `begun`.
    #[cfg(feature = "tracy")]
    drawn_until: std::cell::Cell<i64>,
}

#[cfg(feature = "tracy")]
impl Zones {
    /// Starts the client, which a running profiler finds on this machine.
    pub fn begin() -> Self {
        let client = tracy_client::Client::start();
        // Timestamps are given in nanoseconds since this moment.
        let device = client.clone().new_gpu_context(Some("device"), tracy_client::GpuContextType::Vulkan, 0, 1.0).ok();
        Self { client, device, begun: std::time::Instant::now(), drawn_until: std::cell::Cell::new(0) }
    }

    /// Runs a frame within a zone, and draws the passes that its report lists. On the device, the frame is drawn as if
    /// it ended when the host saw its end.
    pub fn frame<T>(&self, name: &str, run: impl FnOnce() -> T, report: impl Fn(&T) -> Option<&FrameReport>) -> T {
        let zone = self.client.clone().span_alloc(Some(name), "frame", file!(), line!(), 0);
        let made = run();
        drop(zone);
        if let (Some(device), Some(report)) = (&self.device, report(&made)) {
            let nanoseconds = |ms: f64| (1e6 * ms) as i64;
            let end = self.begun.elapsed().as_nanos() as i64;
            let start = end - nanoseconds(crate::stage::span_ms(report)[1]);
            for pass in &report.passes {
                let [from, to] = [pass.start_ms, pass.start_ms + pass.ms].map(|ms| start + nanoseconds(ms));
                // The scene passes of a round stand in the reports of all its methods, and are drawn with the first of
                // them.
                if from < self.drawn_until.get() {
                    continue;
                }
                self.drawn_until.set(to);
                let Ok(mut span) = device.span_alloc(&pass.name, name, file!(), line!()) else { break };
                span.end_zone();
                span.upload_timestamp_start(from);
                span.upload_timestamp_end(to);
            }
        }
        made
    }
}

#[cfg(not(feature = "tracy"))]
impl Zones {
    /// Does nothing without the feature `tracy`.
    pub fn begin() -> Self {
        Self {}
    }

    /// Runs a frame without a zone.
    pub fn frame<T>(&self, _name: &str, run: impl FnOnce() -> T, _report: impl Fn(&T) -> Option<&FrameReport>) -> T {
        run()
    }
}
