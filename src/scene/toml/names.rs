//! Names in messages: quoting, listing, and the nearest known one to a misspelt one.

/// Longest name that is compared or shown whole, in characters: a message stays a message whatever the file holds.
const LONGEST: usize = 60;
/// Most names in a list.
const MOST: usize = 16;

/// The name in quotes, control characters escaped, cut where it is too long to read.
pub(crate) fn quoted(name: &str) -> String {
    match name.char_indices().nth(LONGEST) {
        None => format!("{name:?}"),
        Some((end, _)) => format!("{:?}", format!("{}…", &name[..end])),
    }
}

/// `a, b, c`; what is beyond reading is counted.
pub(crate) fn list<'a>(names: impl IntoIterator<Item = &'a str>) -> String {
    let mut names = names.into_iter();
    let shown: Vec<&str> = names.by_ref().take(MOST).collect();
    match names.count() {
        0 => shown.join(", "),
        more => format!("{} and {more} more", shown.join(", ")),
    }
}

/// `; did you mean "white"?`, or nothing where no known name is near enough to be meant.
pub(crate) fn did_you_mean<'a>(name: &str, known: impl IntoIterator<Item = &'a str>) -> String {
    match nearest(name, known) {
        Some((best, true)) => format!("; did you mean {}?", quoted(best)),
        _ => String::new(),
    }
}

/// The known name with the fewest edits to `name`, and whether it is near enough to be meant: one edit in three
/// characters, or one name within the other (`fov` for `vertical_fov`).
pub(crate) fn nearest<'a>(
    name: &str,
    known: impl IntoIterator<Item = &'a str>,
) -> Option<(&'a str, bool)> {
    // The distance takes time and memory in proportion to both lengths.
    let comparable = |name: &str| name.chars().nth(LONGEST).is_none();
    if !comparable(name) {
        return None;
    }
    let name = name.to_lowercase();
    known
        .into_iter()
        .filter(|candidate| comparable(candidate))
        .map(|candidate| {
            let other = candidate.to_lowercase();
            let edits = strsim::damerau_levenshtein(&name, &other);
            let length = name.chars().count().max(other.chars().count());
            let (short, long) = if name.len() < other.len() {
                (&name, &other)
            } else {
                (&other, &name)
            };
            let within = short.len() >= 3 && long.contains(short.as_str());
            let meant = edits <= (length / 3).max(1) || within;
            (candidate, meant, edits)
        })
        .min_by_key(|&(_, meant, edits)| (!meant, edits))
        .map(|(candidate, meant, _)| (candidate, meant))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_slip_finds_the_name_that_was_meant() {
        let known = ["position", "look_at", "vertical_fov"];
        assert_eq!(nearest("postion", known), Some(("position", true)));
        assert_eq!(nearest("Look_At", known), Some(("look_at", true)));
        assert_eq!(nearest("fov", known), Some(("vertical_fov", true)));
        assert_eq!(
            nearest("zzzzzz", known).map(|(_, meant)| meant),
            Some(false)
        );
        assert_eq!(nearest("x", []), None);
    }

    #[test]
    fn a_message_stays_short_whatever_the_file_holds() {
        let long = "é".repeat(1_000_000);
        assert!(quoted(&long).chars().count() < 70);
        assert_eq!(nearest(&long, ["a"]), None);
        assert_eq!(did_you_mean("a", [long.as_str()]), "");
        assert_eq!(quoted("a\u{1b}[31m"), r#""a\u{1b}[31m""#);
        assert!(list(std::iter::repeat_n("a", 100)).ends_with("a and 84 more"));
    }
}
