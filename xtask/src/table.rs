//! Plain text tables.

/// Lays out rows in columns as wide as their widest cell; columns in `right_aligned` hold numbers.
pub fn layout<const N: usize>(rows: &[[String; N]], right_aligned: [bool; N]) -> String {
    let width = |column: usize| rows.iter().map(|row| row[column].chars().count()).max().unwrap_or(0);
    let widths: [usize; N] = std::array::from_fn(width);
    let mut text = String::new();
    for row in rows {
        let mut line = String::new();
        for column in 0..N {
            let (cell, width) = (&row[column], widths[column]);
            match right_aligned[column] {
                true => line += &format!("{cell:>width$}  "),
                false => line += &format!("{cell:<width$}  "),
            }
        }
        text += line.trim_end();
        text.push('\n');
    }
    text
}

#[cfg(test)]
mod tests {
    #[test]
    fn columns_line_up_and_lines_carry_no_trailing_space() {
        let rows = [["name", "n"].map(String::from), ["a", "1000"].map(String::from)];
        assert_eq!(super::layout(&rows, [false, true]), "name     n\na     1000\n");
    }
}
