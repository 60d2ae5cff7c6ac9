//! `--display-server`: a thread that shows the image to a viewer as it grows. The render never waits for it: what a slow viewer
//! has not taken yet is replaced by newer pixels, and one that is gone is looked for again now and then.

use super::tev::Title;
use crate::cli::messages;
use crate::film::{Image, ImageLayers, PixelBounds};
use crate::math::{Rgb, UVec2};
use crate::session::Live;
use std::io::{self, ErrorKind, Write};
use std::net::{Shutdown, TcpStream, ToSocketAddrs};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering::Relaxed};
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel};
use std::time::{Duration, Instant};

/// Between two looks at what has changed.
const REFRESH: Duration = Duration::from_millis(100);

/// A viewer that does not answer a call, or takes nothing for so long, is given up for a while.
const PATIENCE: Duration = Duration::from_secs(3);

/// The shortest and the longest time until it is looked for again; the first is doubled every time.
const AGAIN: [Duration; 2] = [Duration::from_secs(1), Duration::from_secs(30)];

/// What the whole image may take when the render is over and written.
const LINGER: Duration = Duration::from_secs(2);

/// A viewer that takes nothing for so long then has stalled. A writer that waits is woken when a third of the buffer is free: bytes are taken in lumps.
const STALL: Duration = Duration::from_millis(500);

/// Asks for the names of layers alone.
const NO_PIXELS: PixelBounds = PixelBounds {
    min: UVec2::ZERO,
    max: UVec2::ZERO,
};

/// Side of the squares that a whole image is sent in.
const SIDE: u32 = 256;

/// A viewer that is being shown an image.
pub(super) struct Viewer {
    over: Sender<Vec<f32>>,
    shown: Receiver<()>,
    /// See [`Show::taken`].
    taken: Arc<AtomicU64>,
}

impl Viewer {
    /// Shows `live`, whose layers of light have the names `lights`, under a name. Says so, unless `quiet`, where there is nobody to look at it.
    pub(super) fn start(
        address: &str,
        (name, lights): (String, &[String]),
        live: &Arc<Live>,
        quiet: bool,
    ) -> Viewer {
        let layers = live.layers(NO_PIXELS).channels(lights);
        let own = ["R", "G", "B", "samples.Y"].map(String::from);
        let channels = own.into_iter().chain(layers).collect();
        let (over, orders) = channel();
        let (done, shown) = channel();
        let taken = Arc::<AtomicU64>::default();
        let mut show = Show {
            address: address.to_string(),
            title: Title { name, channels },
            live: Arc::clone(live),
            stream: None,
            taken: Arc::clone(&taken),
            wait: AGAIN[0],
            next: Instant::now(),
            quiet,
        };
        let thread = std::thread::Builder::new().name("viewer".into());
        let started = thread.spawn(move || {
            show.run(&orders);
            let _ = done.send(());
        });
        if let (Err(error), false) = (started, quiet) {
            messages::warning(format!("--display-server {address}: {error}"));
        }
        Viewer { over, shown, taken }
    }

    /// Shows the image that came of it, for as long as a viewer has to take it.
    pub(super) fn finish(self, image: &Image, samples: f32) {
        let colors = image.pixels.iter().map(|rgb| (*rgb, samples));
        if self.over.send(values(colors, &image.layers)).is_ok() {
            self.wait();
        }
    }

    /// Waits until the image is shown, or the viewer has stalled or had its time.
    fn wait(&self) {
        let end = Instant::now() + LINGER;
        let mut before = self.taken.load(Relaxed);
        loop {
            let left = end.saturating_duration_since(Instant::now());
            let answer = self.shown.recv_timeout(left.min(STALL));
            let now = self.taken.load(Relaxed);
            let has_stalled = now == before && now > 0;
            if answer != Err(RecvTimeoutError::Timeout) || has_stalled || left.is_zero() {
                return;
            }
            before = now;
        }
    }
}

/// The values of pixels in all channels: their light, their numbers of samples, their layers.
fn values(colors: impl Iterator<Item = (Rgb, f32)>, layers: &ImageLayers) -> Vec<f32> {
    let one = |(pixel, (light, samples)): (usize, (Rgb, f32))| {
        let own = light.to_array().into_iter().chain([samples]);
        own.chain(layers.values(pixel))
    };
    colors.enumerate().flat_map(one).collect()
}

/// The thread's side.
struct Show {
    address: String,
    title: Title,
    live: Arc<Live>,
    stream: Option<TcpStream>,
    /// Bytes that the viewer, or the system for it, has taken; 0 before it has answered.
    taken: Arc<AtomicU64>,
    /// From one attempt to the next.
    wait: Duration,
    /// When to try again.
    next: Instant,
    /// Trouble is not spoken of, or has been.
    quiet: bool,
}

impl Show {
    /// Until the render is over.
    fn run(&mut self, orders: &Receiver<Vec<f32>>) {
        loop {
            match orders.recv_timeout(REFRESH) {
                Ok(last) => {
                    // Nobody waits longer for a viewer that is not there.
                    if self.stream.is_some() || self.wait == AGAIN[0] {
                        let _ = self.connected().and_then(|()| self.send_last(&last));
                    }
                    return;
                }
                Err(RecvTimeoutError::Disconnected) => return,
                Err(RecvTimeoutError::Timeout) => {}
            }
            if self.stream.is_some() || Instant::now() >= self.next {
                let sent = self.connected().and_then(|()| self.send_changes());
                sent.unwrap_or_else(|error| self.give_up(&error));
            }
        }
    }

    fn give_up(&mut self, error: &io::Error) {
        if !std::mem::replace(&mut self.quiet, true) {
            let reason = match error.kind() {
                ErrorKind::WouldBlock | ErrorKind::TimedOut => "it takes nothing".to_string(),
                _ => error.to_string(),
            };
            messages::warning(format!(
                "--display-server {}: {reason}; the render continues, and looks for a viewer again now and then",
                self.address
            ));
        }
        self.stream = None;
        self.next = Instant::now() + self.wait;
        self.wait = (2 * self.wait).min(AGAIN[1]);
    }

    /// Calls the viewer if need be; then the whole image is new to it.
    fn connected(&mut self) -> io::Result<()> {
        if self.stream.is_some() {
            return Ok(());
        }
        self.stream = Some(connect(&self.address)?);
        self.live.touch_all();
        self.write(&self.title.create(self.live.resolution().to_array()))
    }

    fn send_changes(&mut self) -> io::Result<()> {
        let changes = self.live.changes();
        let is_news = !changes.is_empty();
        for square in changes {
            let colors = self.live.pixels(square).into_iter();
            let colors = colors.map(|(light, samples)| (light, samples as f32));
            self.send(square, &values(colors, &self.live.layers(square)))?;
        }
        if is_news {
            self.wait = AGAIN[0];
        }
        Ok(())
    }

    /// The image as it is written.
    fn send_last(&mut self, last: &[f32]) -> io::Result<()> {
        let (bounds, count) = (self.live.bounds(), self.title.channels.len());
        for square in bounds.tiles(SIDE) {
            let indices = square.pixels().filter_map(|pixel| bounds.index(pixel));
            let pixels = indices.filter_map(|i| last.get(i * count..(i + 1) * count));
            let pixels: Vec<&[f32]> = pixels.collect();
            self.send(square, &pixels.concat())?;
        }
        // Else what a viewer has sent, which nobody reads, might take back what is on its way.
        let end = |stream: &TcpStream| stream.shutdown(Shutdown::Write);
        self.stream.as_ref().map_or(Ok(()), end)
    }

    fn send(&mut self, square: PixelBounds, values: &[f32]) -> io::Result<()> {
        let (at, size) = (square.min.to_array(), square.size().to_array());
        let packet = self.title.update(at, size, values);
        self.write(&packet)
    }

    /// All of it, and counts what is taken as it is.
    fn write(&mut self, mut left: &[u8]) -> io::Result<()> {
        let Some(stream) = self.stream.as_mut() else {
            return Ok(());
        };
        while !left.is_empty() {
            match stream.write(left) {
                Ok(0) => return Err(ErrorKind::WriteZero.into()),
                Ok(count) => {
                    left = left.get(count..).unwrap_or_default();
                    self.taken.fetch_add(count as u64, Relaxed);
                }
                Err(error) if error.kind() == ErrorKind::Interrupted => {}
                Err(error) => return Err(error),
            }
        }
        Ok(())
    }
}

fn connect(address: &str) -> io::Result<TcpStream> {
    let mut last = io::Error::new(ErrorKind::NotFound, "there is no such host");
    for place in address.to_socket_addrs()? {
        match TcpStream::connect_timeout(&place, PATIENCE) {
            Ok(stream) => {
                stream.set_write_timeout(Some(PATIENCE))?;
                stream.set_nodelay(true)?;
                return Ok(stream);
            }
            Err(error) => last = error,
        }
    }
    Err(last)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Half a second, two, and none, with what else a machine does: a viewer that has stalled is left, one that has not answered yet has
    /// its time, and one that has the image is not waited for.
    #[test]
    fn a_viewer_has_its_time_unless_it_has_stalled() {
        let waited = |taken: u64, has_all: bool| {
            let (over, _orders) = channel();
            let (done, shown) = channel();
            if has_all {
                done.send(()).expect("somebody who listens");
            }
            let taken = Arc::new(taken.into());
            let viewer = Viewer { over, shown, taken };
            let start = Instant::now();
            viewer.wait();
            start.elapsed()
        };
        assert!((STALL..LINGER).contains(&waited(1, false)));
        assert!(waited(0, false) >= LINGER);
        assert!(waited(1, true) < STALL);
    }
}
