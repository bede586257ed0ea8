//! Nine-coefficient probes of four light probe images by Paul Debevec, with the numbers that were published.

use super::Probe;

/// Where the numbers are from.
const SOURCE: &str = "Ramamoorthi & Hanrahan 2001, An Efficient Representation for Irradiance Environment Maps, fig. 3; to the digits \
                      of Rost, OpenGL Shading Language, sec. 12.3";

/// RGB of nine coefficients.
type Nine = [[f64; 3]; 9];

/// A name and its coefficients.
const PROBES: [(&str, Nine); 4] = [
    ("grace", GRACE),
    ("eucalyptus", EUCALYPTUS),
    ("st-peters", ST_PETERS),
    ("uffizi", UFFIZI),
];

/// The names of all.
pub const NAMES: [&str; 4] = [PROBES[0].0, PROBES[1].0, PROBES[2].0, PROBES[3].0];

/// The probe of this name, radiance in units of its own, where there is one.
#[must_use]
pub fn published(name: &str) -> Option<Probe> {
    let (name, nine) = PROBES.iter().find(|(known, _)| *known == name)?;
    let mut probe = Probe::radiance(nine.to_vec()).ok()?;
    probe.source = Some(format!("{name}: {SOURCE}"));
    Some(probe)
}

#[rustfmt::skip]
const GRACE: Nine = [
    [0.78908, 0.43710, 0.54161],
    [0.39499, 0.34989, 0.60488],
    [-0.33974, -0.18236, -0.26940],
    [-0.29213, -0.05562, 0.00944],
    [-0.11141, -0.05090, -0.12231],
    [-0.26240, -0.22401, -0.47479],
    [-0.15570, -0.09471, -0.14733],
    [0.56014, 0.21444, 0.13915],
    [0.21205, -0.05432, -0.30374],
];

#[rustfmt::skip]
const EUCALYPTUS: Nine = [
    [0.3783264, 0.4260425, 0.4504587],
    [0.2887813, 0.3586803, 0.4147053],
    [0.0379030, 0.0295216, 0.0098567],
    [-0.1033028, -0.1031690, -0.0884924],
    [-0.0621750, -0.0554432, -0.0396779],
    [0.0077820, -0.0148312, -0.0471301],
    [-0.0935561, -0.1254260, -0.1525629],
    [-0.0572703, -0.0502192, -0.0363410],
    [0.0203348, -0.0044201, -0.0452180],
];

#[rustfmt::skip]
const ST_PETERS: Nine = [
    [0.3623915, 0.2624130, 0.2326261],
    [0.1759130, 0.1436267, 0.1260569],
    [-0.0247311, -0.0101253, -0.0010745],
    [0.0346500, 0.0223184, 0.0101350],
    [0.0198140, 0.0144073, 0.0043987],
    [-0.0469596, -0.0254485, -0.0117786],
    [-0.0898667, -0.0760911, -0.0740964],
    [0.0050194, 0.0038841, 0.0001374],
    [-0.0818750, -0.0321501, 0.0033399],
];

#[rustfmt::skip]
const UFFIZI: Nine = [
    [0.3168843, 0.3073441, 0.3495361],
    [0.3711289, 0.3682168, 0.4292092],
    [-0.0034406, -0.0031891, -0.0039797],
    [-0.0084237, -0.0087049, -0.0116718],
    [-0.0190313, -0.0192164, -0.0250836],
    [-0.0110002, -0.0102972, -0.0119522],
    [-0.2787319, -0.2752035, -0.3184335],
    [0.0011448, 0.0009613, 0.0008975],
    [-0.2419374, -0.2410955, -0.2842899],
];
