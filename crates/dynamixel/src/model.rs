//! Models of the X series, and the part of their control table that all of them share.
//!
//! Addresses and numbers: ROBOTIS' repositories `dynamixel_hardware_interface` (`param/dxl_model/*.model`) and `emanual`
//! (`docs/en/dxl/x/*.md`).

/// Addresses of the control table, with the size and unit of each value.
pub mod address {
    /// Return delay (u8, 2 µs), then drive mode (u8) and operating mode (u8); kept without power.
    pub const RETURN_DELAY: u16 = 9;
    /// Operating mode (u8): 3 position, 5 current-based position; kept without power.
    pub const OPERATING_MODE: u16 = 11;
    /// Greatest position, then the least (u32 each, 4096ths of a turn).
    pub const POSITION_LIMITS: u16 = 48;
    /// Torque on or off (u8).
    pub const TORQUE_ENABLE: u16 = 64;
    /// Hardware errors (u8), one bit each.
    pub const HARDWARE_ERROR: u16 = 70;
    /// D, I and P gain of the position (u16 each, no unit).
    pub const POSITION_GAINS: u16 = 80;
    /// Longest time without an instruction after which the servo stops (u8, 20 ms); 0: none.
    pub const BUS_WATCHDOG: u16 = 98;
    /// Largest current of current-based position mode (i16, the model's unit).
    pub const GOAL_CURRENT: u16 = 102;
    /// Acceleration, then velocity of the profile (u32 each); 0: no profile.
    pub const PROFILE: u16 = 108;
    /// Goal position (i32, 4096ths of a turn).
    pub const GOAL_POSITION: u16 = 116;
    /// Current (i16), velocity (i32), position (i32); at 144 and 146 voltage (u16, 0.1 V) and temperature (u8, degrees Celsius).
    pub const PRESENT: u16 = 126;
}

/// A servo's position where its angle is zero, and positions of a turn.
pub(crate) const CENTRE: i32 = 2048;
const TURN: f64 = 4096.0;
/// Velocity of one unit (rad/s): 0.229 turns a minute.
pub(crate) const VELOCITY_UNIT: f64 = 0.229 * std::f64::consts::TAU / 60.0;
/// Angle of one unit of position (rad).
pub(crate) const POSITION_UNIT: f64 = std::f64::consts::TAU / TURN;

/// A model that the bus drives.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Model {
    /// Name as ROBOTIS writes it, without the letter of the wiring (T, R).
    pub name: &'static str,
    /// Model number, by which the servo answers.
    pub number: u16,
    /// Current of one unit (A); none for a servo without a current sensor.
    pub current_unit: Option<f64>,
    /// Largest baud rate (bits/s).
    pub baud_max: u32,
}

const fn model(name: &'static str, number: u16, current_unit: Option<f64>, baud_max: u32) -> Model {
    Model { name, number, current_unit, baud_max }
}

/// Unit of current of most models (A).
const COMMON: Option<f64> = Some(2.69e-3);

impl Model {
    /// All models.
    pub const ALL: [Self; 11] = [
        model("XL330-M077", 1190, Some(1e-3), 4_000_000),
        model("XL330-M288", 1200, Some(1e-3), 4_000_000),
        model("XL430-W250", 1060, None, 4_500_000),
        model("XM430-W350", 1020, COMMON, 4_500_000),
        model("XM430-W210", 1030, COMMON, 4_500_000),
        model("XM540-W270", 1120, COMMON, 4_500_000),
        model("XM540-W150", 1130, COMMON, 4_500_000),
        model("XH540-W270", 1100, COMMON, 4_500_000),
        model("XH540-W150", 1110, COMMON, 4_500_000),
        model("XH540-V270", 1140, COMMON, 4_500_000),
        model("XH540-V150", 1150, COMMON, 4_500_000),
    ];

    /// Returns the model of a name.
    pub fn by_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|model| model.name == name)
    }

    /// Returns a model number in words.
    pub(crate) fn words(number: u16) -> String {
        let known = Self::ALL.iter().find(|model| model.number == number);
        known.map_or(format!("model number {number}"), |model| format!("{} ({number})", model.name))
    }
}

/// Returns the hardware errors of a status byte in words.
pub(crate) fn hardware_errors(status: u8) -> String {
    const NAMES: [(u8, &str); 6] = [
        (0, "input voltage"),
        (1, "motor hall sensor"),
        (2, "overheating"),
        (3, "motor encoder"),
        (4, "electrical shock"),
        (5, "overload"),
    ];
    let names: Vec<&str> = NAMES.iter().filter(|(bit, _)| status >> bit & 1 == 1).map(|(_, name)| *name).collect();
    if names.is_empty() { format!("status {status}") } else { names.join(", ") }
}
