//! Colours, sizes and the font.

/// Red, green, blue.
pub type Rgb = [u8; 3];

/// Colours that people with any kind of colour vision tell apart (Okabe and Ito 2008).
pub const BLUE: Rgb = [0, 114, 178];
/// See [`BLUE`].
pub const VERMILION: Rgb = [213, 94, 0];
/// See [`BLUE`].
pub const GREEN: Rgb = [0, 158, 115];
/// See [`BLUE`].
pub const PURPLE: Rgb = [170, 80, 140];
/// See [`BLUE`].
pub const SKY: Rgb = [86, 180, 233];
/// See [`BLUE`].
pub const ORANGE: Rgb = [230, 159, 0];
/// What stands behind.
pub const PALE: Rgb = [214, 218, 223];
/// Text and axes.
pub const INK: Rgb = [38, 42, 48];
/// Names of axes, captions.
pub const FAINT: Rgb = [110, 116, 124];
/// Grid.
pub const GRID: Rgb = [232, 234, 237];

/// The font's family.
pub const FAMILY: &str = "Inter";
/// What a browser takes where the font is missing.
pub const FALLBACK: &str = "Inter, 'Helvetica Neue', Helvetica, Arial, 'DejaVu Sans', sans-serif";
/// The font's faces, regular and semibold (SIL Open Font License, assets/fonts/OFL.txt).
pub const FACES: [&[u8]; 2] = [
    include_bytes!("../../assets/fonts/Inter-Regular.ttf"),
    include_bytes!("../../assets/fonts/Inter-SemiBold.ttf"),
];

/// A shade of the sequential colour map, 0 to 1: dark is much.
pub fn shade(share: f64) -> Rgb {
    let color = colorous::MAGMA.eval_continuous((1.0 - share).clamp(0.0, 1.0));
    [color.r, color.g, color.b]
}
