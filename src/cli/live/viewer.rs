//! `--display-server`: a thread that shows the image to a viewer as it grows. The render never waits for it: what a slow viewer
//! has not taken yet is replaced by newer pixels, and one that is gone is looked for again now and then.

use super::tev::{self, Pixel};
use crate::cli::messages;
use crate::film::{Image, PixelBounds};
use crate::session::Live;
use std::io::{self, ErrorKind, Write};
use std::net::{Shutdown, TcpStream, ToSocketAddrs};
use std::sync::Arc;
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel};
use std::time::{Duration, Instant};

/// Between two looks at what has changed.
const REFRESH: Duration = Duration::from_millis(100);

/// A viewer that does not answer a call, or takes nothing for so long, is given up for a while.
const PATIENCE: Duration = Duration::from_secs(3);

/// The shortest and the longest time until it is looked for again; the first is doubled every time.
const AGAIN: [Duration; 2] = [Duration::from_secs(1), Duration::from_secs(30)];

/// What the whole image may take when the render is over.
const LINGER: Duration = Duration::from_secs(2);

/// Side of the squares that a whole image is sent in.
const SIDE: u32 = 256;

/// A viewer that is being shown an image.
pub(super) struct Viewer {
    over: Sender<Vec<Pixel>>,
    shown: Receiver<()>,
}

impl Viewer {
    /// Shows `live` under a name. Says so, unless `quiet`, where there is nobody to look at it.
    pub(super) fn start(address: &str, name: &str, live: &Arc<Live>, quiet: bool) -> Viewer {
        let (over, orders) = channel();
        let (done, shown) = channel();
        let mut show = Show {
            address: address.to_string(),
            name: name.to_string(),
            live: Arc::clone(live),
            stream: None,
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
        Viewer { over, shown }
    }

    /// Shows the image that came of it, for as long as a viewer has to take it.
    pub(super) fn finish(self, image: &Image, samples: f32) {
        let with_samples = |rgb: &crate::math::Rgb| [rgb.x, rgb.y, rgb.z, samples];
        let pixels = image.pixels.iter().map(with_samples).collect();
        if self.over.send(pixels).is_ok() {
            let _ = self.shown.recv_timeout(LINGER);
        }
    }
}

/// The thread's side.
struct Show {
    address: String,
    name: String,
    live: Arc<Live>,
    stream: Option<TcpStream>,
    /// From one attempt to the next.
    wait: Duration,
    /// When to try again.
    next: Instant,
    /// Trouble is not spoken of, or has been.
    quiet: bool,
}

impl Show {
    /// Until the render is over.
    fn run(&mut self, orders: &Receiver<Vec<Pixel>>) {
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
        let mut stream = connect(&self.address)?;
        stream.write_all(&tev::create(&self.name, self.live.resolution().to_array()))?;
        self.live.touch_all();
        self.stream = Some(stream);
        Ok(())
    }

    fn send_changes(&mut self) -> io::Result<()> {
        let changes = self.live.changes();
        let is_news = !changes.is_empty();
        for square in changes {
            let pixels = { self.live.pixels(square).into_iter() }
                .map(|(rgb, samples)| [rgb.x, rgb.y, rgb.z, samples as f32]);
            let pixels: Vec<Pixel> = pixels.collect();
            self.send(square, &pixels)?;
        }
        if is_news {
            self.wait = AGAIN[0];
        }
        Ok(())
    }

    /// The image as it is written.
    fn send_last(&mut self, last: &[Pixel]) -> io::Result<()> {
        let bounds = self.live.bounds();
        for square in bounds.tiles(SIDE) {
            let indices = square.pixels().filter_map(|pixel| bounds.index(pixel));
            let pixels: Vec<Pixel> = indices.filter_map(|i| last.get(i).copied()).collect();
            self.send(square, &pixels)?;
        }
        // Else what a viewer has sent, which nobody reads, might take back what is on its way.
        let end = |stream: &TcpStream| stream.shutdown(Shutdown::Write);
        self.stream.as_ref().map_or(Ok(()), end)
    }

    fn send(&mut self, square: PixelBounds, pixels: &[Pixel]) -> io::Result<()> {
        let (at, size) = (square.min.to_array(), square.size().to_array());
        let packet = tev::update(&self.name, at, size, pixels);
        self.stream
            .as_mut()
            .map_or(Ok(()), |stream| stream.write_all(&packet))
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
