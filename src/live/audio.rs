//! Audio of a live run.

use std::sync::{Arc, Mutex};

use serde::Serialize;
use tokio::sync::broadcast;

use super::lock;
use crate::pipeline::message::{Frame, Record};
use crate::pipeline::{Delivery, RunHandle, Sink, SinkError};
use crate::sound::{Resampler, Source, SurfaceProbe};

/// Maximum number of audio blocks in the queue of a listener.
const QUEUE: usize = 256;
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

/// A shared block of samples of the sound.
pub type Sound = Arc<[f32]>;

/// Streams the sound of a run to listeners at the measured playback speed, which lowers the pitch
/// accordingly.
pub struct AudioStream {
    source: Source,
    handle: Mutex<Option<RunHandle>>,
    blocks: broadcast::Sender<Sound>,
    info: Mutex<AudioInfo>,
}

/// Description of the audio signal, for a listener.
#[derive(Clone, Debug, Default, Serialize)]
pub struct AudioInfo {
    /// Quantity and point.
    pub what: String,
    /// Time stretch: the sound is slower and lower by this factor.
    pub time_stretch: f32,
}

impl AudioStream {
    /// Creates a stream of the given quantity and point.
    pub fn new(source: Source) -> Self {
        Self {
            source,
            handle: Mutex::default(),
            blocks: broadcast::channel(QUEUE).0,
            info: Mutex::default(),
        }
    }

    /// Subscribes a listener.
    pub fn subscribe(&self) -> broadcast::Receiver<Sound> {
        self.blocks.subscribe()
    }

    /// Description of the audio signal at present.
    pub fn info(&self) -> AudioInfo {
        lock(&self.info).clone()
    }

    /// Follows the playback speed of a run.
    pub(super) fn set_run(&self, handle: RunHandle) {
        *lock(&self.handle) = Some(handle);
    }

    /// Creates the sink for the samples of a run.
    pub(super) fn sink(self: &Arc<Self>) -> AudioSink {
        AudioSink {
            stream: Arc::clone(self),
            rate: 0.0,
            probe: None,
            resampler: None,
            level: 0.0,
        }
    }

    /// Present playback speed.
    fn speed(&self) -> f64 {
        let handle = lock(&self.handle);
        let status = handle.as_ref().map(RunHandle::status);
        status.map_or(1.0, |now| {
            now.measured_speed.unwrap_or(now.speed).min(now.speed)
        })
    }
}

/// Sink that converts the samples of a run to audio.
pub struct AudioSink {
    stream: Arc<AudioStream>,
    /// Sample rate of the run, Hz.
    rate: f64,
    probe: Option<SurfaceProbe>,
    resampler: Option<Resampler>,
    /// Peak level of the recent past, m/s or m/s^2.
    level: f32,
}

impl AudioSink {
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
        if let Some(probe) = &mut self.probe {
            resampler.push(probe.samples(frame), &mut sound);
        }
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
            Record::Header(header) => {
                self.rate = header.sample_rate;
                let probe = SurfaceProbe::with_fallback(self.stream.source, &header);
                lock(&self.stream.info).what = probe.description();
                self.probe = Some(probe);
            }
            // Without listeners there is nothing to compute.
            Record::Samples(_) if self.stream.blocks.receiver_count() == 0 => self.resampler = None,
            Record::Samples(frame) => {
                let speed = self.stream.speed();
                lock(&self.stream.info).time_stretch = (1.0 / speed) as f32;
                let sound = self.convert(&frame, speed);
                if !sound.is_empty() {
                    // The last listener may have disconnected in the meantime.
                    let _ = self.stream.blocks.send(sound.into());
                }
            }
            _ => {}
        }
        Ok(())
    }

    fn delivery(&self) -> Delivery {
        Delivery::LatestPictures
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
        let header = Simulation::new(&scene).unwrap().header("");
        let mut sink = Arc::new(AudioStream::new(Source::default())).sink();
        sink.rate = 1e5;
        sink.probe = Some(SurfaceProbe::with_fallback(Source::default(), &header));
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
