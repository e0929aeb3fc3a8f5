//! The macro `settings!`, with which each tracker's `config.rs` defines its settings. It generates the fields of the
//! configuration, names and ranges for every language, and the order of values in saved targets and records.

use super::ConfigError;
use crate::similarity::Table;

/// A setting of a configuration. Its values are whole numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct Setting {
    name: &'static str,
    /// The type, which determines the count of values.
    pub shape: Shape,
    /// The lowest value. The denominator of a fraction is also at least 1.
    pub lowest: u16,
    /// The highest value.
    pub highest: u16,
    /// The count of reserved values that precede the setting in a record. Each reserved value is 1.
    pub(super) reserved_before: usize,
}

/// The type of a setting.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Shape {
    /// A whole number.
    Number,
    /// A switch: 0 or 1.
    Switch,
    /// Two numbers: numerator and denominator.
    Fraction,
    /// Two numbers: x and y.
    Radius,
    /// Four margins: left, top, right and bottom.
    Margins,
}

impl Shape {
    /// The count of values: 1, 2 or 4.
    #[must_use]
    pub const fn count(self) -> usize {
        match self {
            Self::Number | Self::Switch => 1,
            Self::Fraction | Self::Radius => 2,
            Self::Margins => 4,
        }
    }
}

impl Setting {
    #[doc(hidden)]
    #[must_use]
    pub const fn new(name: &'static str, shape: Shape, (lowest, highest): (u16, u16), reserved_before: usize) -> Self {
        Self { name, shape, lowest, highest, reserved_before }
    }

    /// The name of the setting, which is the name of its field in the configuration.
    #[must_use]
    pub const fn name(&self) -> &'static str {
        match self.name.split_at_checked(self.name.len().saturating_sub(1)) {
            Some((name, _)) => name,
            None => self.name,
        }
    }

    /// The name followed by a zero byte, for C.
    #[doc(hidden)]
    #[must_use]
    pub const fn name_with_zero(&self) -> &'static str {
        self.name
    }

    /// Checks the count and the range of the `values` for this setting.
    ///
    /// # Errors
    /// [`ConfigError::WrongCount`] or [`ConfigError::OutOfRange`].
    pub fn check(&self, values: &[u16]) -> Result<(), ConfigError> {
        let (name, highest) = (self.name(), self.highest);
        if values.len() != self.shape.count() {
            return Err(ConfigError::WrongCount { name, count: self.shape.count() });
        }
        for (index, &found) in values.iter().enumerate() {
            let is_denominator = self.shape == Shape::Fraction && index == 1;
            let lowest = if is_denominator { self.lowest.max(1) } else { self.lowest };
            if !(lowest..=highest).contains(&found) {
                return Err(ConfigError::OutOfRange { name, lowest, highest, found });
            }
        }
        Ok(())
    }
}

/// A configuration whose settings have names. The trait is sealed: the configurations of both trackers implement it.
///
/// ```
/// use smr_core::{ConfigError, Settings, robust::Config};
/// let mut config = Config::robust();
/// config.set("reach", &[5])?;
/// assert_eq!((config.reach, config.get("reach")), (5, Some([5, 0, 0, 0])));
/// assert_eq!(config.set("reach", &[100]).unwrap_err().to_string(), "reach is 4 to 8, not 100");
/// assert_eq!(config.set("speed", &[1]), Err(ConfigError::UnknownSetting));
/// assert_eq!(Config::SETTINGS.len(), Config::TEXTS.len());
/// # Ok::<(), ConfigError>(())
/// ```
pub trait Settings: Numbers {
    /// All settings, in the order in which records and saved targets hold them.
    const SETTINGS: &'static [Setting];
    /// A description of each setting, in one or two sentences.
    const TEXTS: &'static [&'static str];

    /// All settings, with the ranges of this configuration: the largest `reach` depends on the
    /// [`Size`](crate::robust::Size) of the tracker.
    fn settings(&self) -> impl Iterator<Item = Setting> {
        Self::SETTINGS.iter().map(|&setting| self.limited(setting))
    }

    /// Sets a setting by its name. [`Target::with`](crate::Target::with) later checks it against other settings.
    ///
    /// # Errors
    /// [`ConfigError::UnknownSetting`], [`ConfigError::WrongCount`] or [`ConfigError::OutOfRange`]; nothing is changed.
    fn set(&mut self, name: &str, values: &[u16]) -> Result<(), ConfigError> {
        let (setting, at) = find(Self::SETTINGS, name).ok_or(ConfigError::UnknownSetting)?;
        self.limited(*setting).check(values)?;
        let mut numbers = self.numbers();
        numbers.as_mut().iter_mut().skip(at).zip(values).for_each(|(place, &value)| *place = value);
        self.put(self.table(), &numbers);
        Ok(())
    }

    /// The values of a setting, padded with zeros; `None` if no setting has this name.
    fn get(&self, name: &str) -> Option<[u16; 4]> {
        let (setting, at) = find(Self::SETTINGS, name)?;
        let (mut values, numbers) = ([0; 4], self.numbers());
        let own = numbers.as_ref().iter().skip(at).take(setting.shape.count());
        values.iter_mut().zip(own).for_each(|(to, &from)| *to = from);
        Some(values)
    }

    /// Restores a configuration from its similarity `table` and the `numbers` that a [record](crate::record) stores.
    ///
    /// # Errors
    /// [`ConfigError`] if the values are not those of a valid configuration.
    fn of_numbers(table: &'static Table, numbers: &[u16]) -> Result<Self, ConfigError> {
        if ![Self::COUNT, Self::MIN].contains(&numbers.len()) {
            return Err(ConfigError::WrongCount { name: "the configuration", count: Self::COUNT });
        }
        let (mut config, mut all) = (Self::default(), Self::default().numbers());
        all.as_mut().iter_mut().zip(numbers.iter().chain(&[0])).for_each(|(to, &from)| *to = from);
        let mut rest = all.as_ref();
        for setting in Self::SETTINGS {
            let (reserved, after) = rest.split_at_checked(setting.reserved_before).unwrap_or_default();
            if let Some(&found) = reserved.iter().find(|&&one| one != 1) {
                return Err(ConfigError::OutOfRange { name: RESERVED_NAME, lowest: 1, highest: 1, found });
            }
            let (values, after) = after.split_at_checked(setting.shape.count()).unwrap_or_default();
            setting.check(values)?;
            rest = after;
        }
        config.put(table, &all);
        config.check_all()?;
        Ok(config)
    }
}

/// The letter of a tracker in saved targets and records.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub enum Kind {
    Paper = b'P',
    Robust = b'R',
    /// The robust tracker of the small size.
    RobustSmall = b'S',
}

/// The name that errors use for the reserved values of a record, which are always 1.
const RESERVED_NAME: &str = "parts";

/// The values of a configuration that affect the tracker's answers, except the similarity table, in a record's order.
pub trait Numbers: Copy + Default {
    type Array: AsRef<[u16]> + AsMut<[u16]>;
    const COUNT: usize;
    /// The count of values in a record that leaves out the last value, because it is 0.
    const MIN: usize;
    /// The name of the setting that each value belongs to.
    const NAMES: &'static [&'static str];
    /// The trackers that have this configuration.
    const KINDS: &'static [Kind];

    fn numbers(&self) -> Self::Array;
    /// Sets the table and all values. Each value must be in its range.
    fn put(&mut self, table: &'static Table, numbers: &Self::Array);
    fn table(&self) -> &'static Table;
    /// The setting, with the range that this configuration allows.
    fn limited(&self, setting: Setting) -> Setting;
    fn check_all(&self) -> Result<(), ConfigError>;
}

/// Calls `add` with each value of a record: the entries of the table, then the configuration. The refiner's switch is
/// left out if the refiner is off, so the record equals that of a build without the refiner.
pub(super) fn recorded<C: Numbers>(config: &C, add: impl FnMut(u16)) {
    let numbers = config.numbers();
    let numbers = numbers.as_ref();
    let count = if numbers.last() == Some(&0) { C::MIN } else { C::COUNT };
    config.table().entries().iter().chain(numbers.iter().take(count)).copied().for_each(add);
}

/// The setting with this name, and the index of its first value.
fn find(settings: &'static [Setting], name: &str) -> Option<(&'static Setting, usize)> {
    let mut at = 0;
    settings.iter().find_map(|setting| {
        at += setting.reserved_before;
        let found = (setting.name() == name).then_some((setting, at));
        at += setting.shape.count();
        found
    })
}

#[allow(clippy::indexing_slicing)] // at compile time
pub(super) const fn names<const COUNT: usize>(settings: &[Setting]) -> [&'static str; COUNT] {
    let (mut names, mut number, mut setting) = ([RESERVED_NAME; COUNT], 0, 0);
    while setting < settings.len() {
        number += settings[setting].reserved_before;
        let end = number + settings[setting].shape.count();
        while number < end {
            names[number] = settings[setting].name();
            number += 1;
        }
        setting += 1;
    }
    names
}

/// Returns early with an error if a value is outside its range.
macro_rules! in_range {
    ($name:expr, $found:expr, $lowest:expr, $highest:expr) => {
        if $found < $lowest || $highest < $found {
            return Err(crate::track::ConfigError::OutOfRange {
                name: $name,
                lowest: $lowest,
                highest: $highest,
                found: $found,
            });
        }
    };
}

/// The values of settings as an array: `flat!(config [] Type setting Type setting ...)`.
macro_rules! flat {
    ($of:ident [$($all:expr,)*]) => { [$($all),*] };
    ($of:ident [$($all:expr,)*] after 4 $($rest:tt)*) => { flat!($of [$($all,)* 1, 1, 1, 1,] $($rest)*) };
    ($of:ident [$($all:expr,)*] Fraction $name:ident $($rest:tt)*) => {
        flat!($of [$($all,)* $of.$name.numerator, $of.$name.denominator,] $($rest)*)
    };
    ($of:ident [$($all:expr,)*] Radius $name:ident $($rest:tt)*) => {
        flat!($of [$($all,)* $of.$name.x, $of.$name.y,] $($rest)*)
    };
    ($of:ident [$($all:expr,)*] Margins $name:ident $($rest:tt)*) => {
        flat!($of [$($all,)* $of.$name.left, $of.$name.top, $of.$name.right, $of.$name.bottom,] $($rest)*)
    };
    ($of:ident [$($all:expr,)*] $number:ident $name:ident $($rest:tt)*) => {
        flat!($of [$($all,)* $of.$name as u16,] $($rest)*)
    };
}

/// Code for one type of setting: its `Shape`, its conversion from `u16` values, or its range check.
#[rustfmt::skip] // a line for each
macro_rules! of_type {
    (shape bool) => { Shape::Switch };
    (shape u8) => { Shape::Number };
    (shape u16) => { Shape::Number };
    (shape $shape:ident) => { Shape::$shape };
    (value Fraction $next:ident) => { Fraction { numerator: $next(), denominator: $next() } };
    (value Radius $next:ident) => { Radius { x: $next(), y: $next() } };
    (value Margins $next:ident) => { Margins { left: $next(), top: $next(), right: $next(), bottom: $next() } };
    (value bool $next:ident) => { $next() != 0 };
    (value u8 $next:ident) => { $next().to_le_bytes()[0] };
    (value u16 $next:ident) => { $next() };
    (check Fraction $of:expr, $name:expr, $lowest:literal, $highest:literal) => {
        in_range!($name, $of.numerator, $lowest, $highest);
        in_range!($name, $of.denominator, if $lowest > 1 { $lowest } else { 1 }, $highest);
    };
    (check u8 $of:expr, $name:expr, $lowest:literal, $highest:literal) => { in_range!($name, $of as u16, $lowest, $highest); };
    (check u16 $of:expr, $name:expr, $lowest:literal, $highest:literal) => { in_range!($name, $of, $lowest, $highest); };
    (check $full:ident $($rest:tt)*) => {};
}

/// Defines a configuration: fields that are no settings, then settings with their types and ranges. `at_most FIELD` means
/// that this field further limits the range, `after N` that N reserved values, always 1, precede the setting in a record.
macro_rules! settings {
    (
        $($kind:ident)|+, $least:expr; $(#[$about:meta])*
        { $($(#[$other_about:meta])* $visible:vis $other:ident: $other_type:ty,)* }
        $(
            $(#[doc = $text:literal])+
            $name:ident: $type:ident, $lowest:literal..=$highest:literal $(at_most $most:ident)? $(after $ones:tt)?;
        )+
    ) => {
        $(#[$about])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        #[cfg_attr(feature = "defmt", derive(defmt::Format))]
        #[non_exhaustive]
        pub struct Config {
            $($(#[$other_about])* $visible $other: $other_type,)*
            $($(#[doc = $text])+ pub $name: $type,)+
        }

        impl Config {
            #[inline(always)]
            #[allow(unused_comparisons, clippy::absurd_extreme_comparisons)] // ranges that are those of the type
            const fn check_ranges(&self) -> Result<(), ConfigError> {
                $(
                    $(in_range!(stringify!($name), self.$name as u16, $lowest, self.$most as u16);)?
                    of_type!(check $type self.$name, stringify!($name), $lowest, $highest);
                )+
                Ok(())
            }
        }

        impl Settings for Config {
            const SETTINGS: &'static [Setting] = &[$(Setting::new(
                concat!(stringify!($name), "\0"), of_type!(shape $type), ($lowest, $highest), 0 $(+ $ones)?,
            )),+];
            const TEXTS: &'static [&'static str] = &[$(concat!($($text),+).trim_ascii_start()),+];
        }

        impl Numbers for Config {
            type Array = [u16; Self::COUNT];
            const COUNT: usize = 0 $(+ of_type!(shape $type).count() $(+ $ones)?)+;
            const MIN: usize = Self::COUNT - $least;
            const NAMES: &'static [&'static str] = &names::<{ Self::COUNT }>(Self::SETTINGS);
            const KINDS: &'static [Kind] = &[$(Kind::$kind),+];

            #[inline(never)]
            fn numbers(&self) -> Self::Array {
                flat!(self [] $($(after $ones)? $type $name)+)
            }

            fn put(&mut self, table: &'static Table, numbers: &Self::Array) {
                self.table = table;
                let mut numbers = numbers.iter().copied();
                let mut next = || numbers.next().unwrap_or_default();
                $(
                    $((0..$ones).for_each(|_| { next(); });)?
                    self.$name = of_type!(value $type next);
                )+
            }

            fn table(&self) -> &'static Table {
                self.table
            }

            #[allow(unused_mut)] // if no field limits a setting
            fn limited(&self, mut setting: Setting) -> Setting {
                $($(
                    if setting.name() == stringify!($name) {
                        setting.highest = self.$most.into();
                    }
                )?)+
                setting
            }

            fn check_all(&self) -> Result<(), ConfigError> {
                self.check()
            }
        }
    };
}
