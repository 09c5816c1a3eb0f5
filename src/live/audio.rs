//! Audio of a live run.

use std::sync::Arc;

use serde::Serialize;
use tokio::sync::broadcast;

use crate::pipeline::message::{Frame, Header, Record};
use crate::pipeline::{RunHandle, Sink, SinkError};
use crate::sound::{Resampler, Source, SurfaceProbe};

/// Maximum number of audio blocks in the queue of a listener.
pub(super) const QUEUE: usize = 256;
/// Peak level, relative to full scale.
const PEAK: f32 = 0.7;
/// Half-life of the peak detector, s of audio: the gain recovers with this time constant.
const HALF_LIFE: f32 = 0.5;
/// Time stretch above which the sound would be too low to hear; the output is then silent.
const MAX_STRETCH: f64 = 500.0;
/// Maximum duration of audio per frame, s. A frame computed at a higher playback speed could be very long.
const MAX_FRAME_AUDIO: f64 = 0.1;
/// Minimum peak level that is amplified to full level, m/s or m/s^2.
const MIN_LEVEL: f32 = 1e-7;

/// A block of samples with its description, shared by all listeners.
pub(super) type Sound = Arc<(AudioInfo, Vec<f32>)>;

/// Description of the audio signal, for a listener.
#[derive(Clone, Debug, Default, Serialize)]
pub(super) struct AudioInfo {
    /// Quantity and point.
    pub what: String,
    /// Time stretch: the sound is slower and lower by this factor.
    pub time_stretch: f32,
}

/// Sink that sends the sound of a run to listeners at the measured playback speed, which lowers the pitch accordingly.
pub(super) struct AudioSink {
    /// The run, whose playback speed is followed.
    run: RunHandle,
    listeners: broadcast::Sender<Sound>,
    /// Sample rate of the run, Hz.
    rate: f64,
    probe: SurfaceProbe,
    resampler: Option<Resampler>,
    /// Peak level of the recent past, m/s or m/s^2.
    level: f32,
}

impl AudioSink {
    /// A sink for the sound of the given quantity and point, for the run described by `header`.
    pub fn new(
        source: Source,
        header: &Header,
        run: RunHandle,
        listeners: broadcast::Sender<Sound>,
    ) -> Self {
        Self {
            run,
            listeners,
            rate: header.sample_rate,
            probe: SurfaceProbe::with_fallback(source, header),
            resampler: None,
            level: 0.0,
        }
    }

    /// The audio of a frame at a playback speed.
    fn convert(&mut self, frame: &Frame, speed: f64) -> Vec<f32> {
        let length = frame.end() - frame.t0;
        if speed * MAX_STRETCH < 1.0 {
            self.resampler = None;
            let silence = (length / speed).min(1.0) * f64::from(crate::sound::RATE);
            return vec![0.0; silence as usize];
        }
        let rate = self.rate * speed.max(length / MAX_FRAME_AUDIO);
        let resampler = self.resampler.get_or_insert_with(|| Resampler::new(rate));
        resampler.set_rate(rate);
        let mut sound = Vec::new();
        resampler.push(self.probe.samples(frame), &mut sound);
        self.normalise(&mut sound);
        sound
    }

    /// Normalises the level. Signals below [`MIN_LEVEL`] stay quiet.
    fn normalise(&mut self, sound: &mut [f32]) {
        let fall = 0.5f32.powf(1.0 / (HALF_LIFE * crate::sound::RATE as f32));
        for x in sound {
            self.level = (self.level * fall).max(x.abs());
            *x *= PEAK / self.level.max(MIN_LEVEL);
        }
    }
}

impl Sink for AudioSink {
    fn accept(&mut self, record: Record) -> Result<(), SinkError> {
        match record {
            // Without listeners there is nothing to compute.
            Record::Samples(_) if self.listeners.receiver_count() == 0 => self.resampler = None,
            Record::Samples(frame) => {
                let now = self.run.status();
                let speed = now.measured_speed.unwrap_or(now.speed).min(now.speed);
                let sound = self.convert(&frame, speed);
                if !sound.is_empty() {
                    let info = AudioInfo {
                        what: self.probe.description(),
                        time_stretch: (1.0 / speed) as f32,
                    };
                    // The last listener may have disconnected in the meantime.
                    let _ = self.listeners.send(Arc::new((info, sound)));
                }
            }
            _ => {}
        }
        Ok(())
    }

    fn may_skip_pictures(&self) -> bool {
        true
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pipeline::{Simulation, Source as _};
    use crate::scene::Scene;

    #[test]
    fn audio_of_a_frame_has_a_maximum_duration() {
        let scene = Scene::load("mass-on-belt").unwrap();
        let mut header = Simulation::new(&scene).unwrap().header("");
        header.sample_rate = 1e5;
        let (run, listeners) = (RunHandle::new(1.0), broadcast::channel(QUEUE).0);
        let mut sink = AudioSink::new(Source::default(), &header, run, listeners);
        let frame = |count: usize| Frame {
            dt: 1e-5,
            velocity: vec![1e-3; count],
            displacement: vec![0.0; count],
            ..Frame::default()
        };
        // Frames of 1/60 s of real time: 800 audio samples.
        let life: usize = (0..60).map(|_| sink.convert(&frame(1667), 1.0).len()).sum();
        assert!((47_000..48_100).contains(&life), "{life}");
        // The same frame at a hundredth of the speed would last for seconds.
        assert!(sink.convert(&frame(1667), 0.01).len() < 6000);
        // At an inaudibly low speed there is silence for the duration of the frame, at most one second.
        assert_eq!(sink.convert(&frame(1), 1e-5).len(), 48_000);
        assert_eq!(sink.convert(&frame(1667), 1e-5), vec![0.0; 48_000]);
    }
}
