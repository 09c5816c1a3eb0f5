//! The sound of a live run for those who listen, while it is computed.

use std::sync::atomic::{AtomicU32, Ordering};
use std::sync::{Arc, Mutex, PoisonError};

use tokio::sync::broadcast;

use crate::pipeline::message::{Frame, Record};
use crate::pipeline::{Delivery, Helm, Sink, SinkError};
use crate::sound::{Pickup, Resampler, Source};

/// Pieces that may wait for a listener.
const WAITING: usize = 256;
/// How loud the loudest is, of full scale.
const LOUDEST: f32 = 0.7;
/// Time in which the level falls to half of what it was, s of sound: so fast the gain rises again.
const HALF_LIFE: f32 = 0.5;
/// How many times slower than life is too low to be heard; then there is silence.
const TOO_SLOW: f64 = 500.0;
/// Sound of a frame, at most, s: one that was made at another pace than the present one could be very long.
const LONGEST: f64 = 0.1;
/// The least level that is made louder, m/s or m/s^2: below it there is silence.
const FAINTEST: f32 = 1e-7;

/// Samples of sound, shared.
pub type Sound = Arc<[f32]>;

/// Plays a run to whoever listens, at the pace that it reaches: slower than life it sounds lower.
pub struct Ear {
    source: Source,
    helm: Mutex<Option<Helm>>,
    news: broadcast::Sender<Sound>,
    /// How many times slower than life it plays now, as the bits of an `f32`.
    slower: AtomicU32,
    /// What is heard, in a few words.
    words: Mutex<String>,
}

impl Ear {
    /// Hears so much of the motion.
    pub fn new(source: Source) -> Self {
        Self {
            source,
            helm: Mutex::default(),
            news: broadcast::channel(WAITING).0,
            slower: AtomicU32::new(1.0f32.to_bits()),
            words: Mutex::default(),
        }
    }

    /// Somebody listens from now on.
    pub fn listen(&self) -> broadcast::Receiver<Sound> {
        self.news.subscribe()
    }

    /// What is heard of this run, in a few words.
    pub fn words(&self) -> String {
        let words = self.words.lock().unwrap_or_else(PoisonError::into_inner);
        words.clone()
    }

    /// How many times slower than life, and so lower, it sounds now.
    pub fn slower(&self) -> f32 {
        f32::from_bits(self.slower.load(Ordering::Relaxed))
    }

    /// Goes at the pace of a run.
    pub(super) fn follow(&self, helm: Helm) {
        *self.helm.lock().unwrap_or_else(PoisonError::into_inner) = Some(helm);
    }

    /// Takes the samples of a run.
    pub(super) fn tap(self: &Arc<Self>) -> Tap {
        Tap {
            ear: Arc::clone(self),
            rate: 0.0,
            pickup: None,
            resampler: None,
            level: 0.0,
        }
    }

    /// The pace that it goes at now.
    fn pace(&self) -> f64 {
        let helm = self.helm.lock().unwrap_or_else(PoisonError::into_inner);
        let gait = helm.as_ref().map(Helm::gait);
        gait.map_or(1.0, |gait| gait.reached.unwrap_or(gait.pace).min(gait.pace))
    }
}

/// The end of a run's road that is heard.
pub struct Tap {
    ear: Arc<Ear>,
    /// Samples of the run, Hz.
    rate: f64,
    pickup: Option<Pickup>,
    resampler: Option<Resampler>,
    /// The loudest of late, m/s or m/s^2.
    level: f32,
}

impl Tap {
    /// The sound of a frame at a pace.
    fn hear(&mut self, frame: &Frame, pace: f64) -> Vec<f32> {
        let length = frame.end() - frame.t0;
        if pace * TOO_SLOW < 1.0 {
            self.resampler = None;
            let silence = (length / pace).min(1.0) * f64::from(crate::sound::RATE);
            return vec![0.0; silence as usize];
        }
        let rate = self.rate * pace.max(length / LONGEST);
        let resampler = self.resampler.get_or_insert_with(|| Resampler::new(rate));
        resampler.set_rate(rate);
        let mut sound = Vec::new();
        if let Some(pickup) = &mut self.pickup {
            resampler.push(pickup.hear(frame), &mut sound);
        }
        self.level(&mut sound);
        sound
    }

    /// Makes it as loud as it may be; what is faint stays faint.
    fn level(&mut self, sound: &mut [f32]) {
        let fall = 0.5f32.powf(1.0 / (HALF_LIFE * crate::sound::RATE as f32));
        for x in sound {
            self.level = (self.level * fall).max(x.abs());
            *x *= LOUDEST / self.level.max(FAINTEST);
        }
    }
}

impl Sink for Tap {
    fn accept(&mut self, record: Record) -> Result<(), SinkError> {
        match record {
            Record::Header(header) => {
                self.rate = header.sample_rate;
                let pickup = Pickup::wherever(self.ear.source, &header);
                let words = self.ear.words.lock();
                *words.unwrap_or_else(PoisonError::into_inner) = pickup.words();
                self.pickup = Some(pickup);
            }
            // While nobody listens there is nothing to do.
            Record::Samples(_) if self.ear.news.receiver_count() == 0 => self.resampler = None,
            Record::Samples(frame) => {
                let pace = self.ear.pace();
                let slower = (1.0 / pace) as f32;
                self.ear.slower.store(slower.to_bits(), Ordering::Relaxed);
                let sound = self.hear(&frame, pace);
                if !sound.is_empty() {
                    // The last listener may just have left.
                    let _ = self.ear.news.send(sound.into());
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
    use crate::pipeline::steerable;
    use crate::scene::Scene;

    #[test]
    fn a_frame_made_at_another_pace_is_not_played_for_minutes() {
        let scene = Scene::load("mass-on-belt").unwrap();
        let header = steerable(&scene).unwrap().header("");
        let mut tap = Arc::new(Ear::new(Source::default())).tap();
        tap.rate = 1e5;
        tap.pickup = Some(Pickup::wherever(Source::default(), &header));
        let frame = |count: usize| Frame {
            dt: 1e-5,
            velocity: vec![1e-3; count],
            displacement: vec![0.0; count],
            ..Frame::default()
        };
        // Frames of a sixtieth of a second of real time: 800 samples of sound.
        let life: usize = (0..60).map(|_| tap.hear(&frame(1667), 1.0).len()).sum();
        assert!((47_000..48_100).contains(&life), "{life}");
        // What was made so and is played a hundred times slower would last for seconds.
        assert!(tap.hear(&frame(1667), 0.01).len() < 6000);
        // Too slow to hear is silence, as long as the frame lasts, or a second.
        assert_eq!(tap.hear(&frame(1), 1e-5).len(), 48_000);
        assert_eq!(tap.hear(&frame(1667), 1e-5), vec![0.0; 48_000]);
    }
}
