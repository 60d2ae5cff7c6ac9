//! Packets of tev's protocol (Thomas Müller's image viewer, <https://github.com/Tom94/tev>, its `Ipc`), which pbrt-v4 and other
//! viewers speak, too: the length as 32 bits, itself counted; a byte for the kind; what belongs to that. Numbers are
//! little-endian, strings end with a zero byte.

/// Kinds of packets.
const CREATE_IMAGE: u8 = 4;
/// Whose channels lie in one row of numbers, each with an offset and a stride.
const UPDATE_IMAGE_V3: u8 = 6;

/// An image that a viewer is shown.
pub(super) struct Title {
    pub name: String,
    /// Of its channels; those of one layer have its name before a dot.
    pub channels: Vec<String>,
}

impl Title {
    /// A new black image of this many pixels, in front of the others.
    pub(super) fn create(&self, size: [u32; 2]) -> Vec<u8> {
        let mut packet = Packet::new(CREATE_IMAGE, true, &self.name);
        size.into_iter().for_each(|n| packet.number(n));
        packet.channels(&self.channels);
        packet.finish()
    }

    /// The pixels, row by row, of a rectangle from the pixel `at`: of each the values of all channels.
    pub(super) fn update(&self, at: [u32; 2], size: [u32; 2], values: &[f32]) -> Vec<u8> {
        let mut packet = Packet::new(UPDATE_IMAGE_V3, false, &self.name);
        packet.channels(&self.channels);
        at.into_iter().chain(size).for_each(|n| packet.number(n));
        let count = self.channels.len() as i64;
        (0..count).for_each(|offset| packet.long(offset));
        (0..count).for_each(|_| packet.long(count));
        let bytes = values.iter().flat_map(|value| value.to_le_bytes());
        packet.0.extend(bytes);
        packet.finish()
    }
}

struct Packet(Vec<u8>);

impl Packet {
    fn new(kind: u8, in_front: bool, name: &str) -> Packet {
        // The length is not known yet.
        let mut packet = Packet(vec![0, 0, 0, 0, kind, in_front.into()]);
        packet.string(name);
        packet
    }

    fn string(&mut self, text: &str) {
        self.0.extend(text.bytes().filter(|byte| *byte != 0));
        self.0.push(0);
    }

    fn number(&mut self, number: u32) {
        self.0.extend(number.to_le_bytes());
    }

    fn long(&mut self, number: i64) {
        self.0.extend(number.to_le_bytes());
    }

    fn channels(&mut self, names: &[String]) {
        self.number(names.len() as u32);
        names.iter().for_each(|name| self.string(name));
    }

    fn finish(mut self) -> Vec<u8> {
        let length = self.0.len() as u32;
        self.0[..4].copy_from_slice(&length.to_le_bytes());
        self.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn packets_are_as_the_protocol_has_them() {
        let expected =
            b"\x28\0\0\0\x04\x01a.exr\0\x03\0\0\0\x02\0\0\0\x04\0\0\0R\0G\0B\0samples.Y\0";
        let title = |name: &str| Title {
            name: name.to_string(),
            channels: ["R", "G", "B", "samples.Y"].map(String::from).to_vec(),
        };
        assert_eq!(title("a.exr").create([3, 2]), expected[..]);
        let packet = title("a").update([5, 6], [1, 1], &[0.5, 1.0, 2.0, 8.0]);
        assert_eq!(
            packet.len(),
            u32::from_le_bytes([packet[0], packet[1], packet[2], packet[3]]) as usize
        );
        assert!(
            packet[4..].starts_with(b"\x06\0a\0\x04\0\0\0R\0G\0B\0samples.Y\0\x05\0\0\0\x06\0\0\0")
        );
        assert!(packet.ends_with(b"\0\0\0\x3f\0\0\x80\x3f\0\0\0\x40\0\0\0\x41"));
    }
}
