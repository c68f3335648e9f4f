//! Tables over wavelength that are compiled into the program, read once and interpolated linearly.

/// Columns tabulated over strictly increasing wavelengths in nm.
#[derive(Clone, Debug)]
pub(crate) struct WavelengthTable<const N: usize> {
    rows: Vec<(f64, [f64; N])>,
}

impl<const N: usize> WavelengthTable<N> {
    /// Reads an embedded CSV whose first column is the wavelength in nm; lines that are not numbers are headers.
    ///
    /// Only for data of the program itself: the tests below count the rows, so nothing can be lost silently.
    pub(crate) fn from_embedded(csv: &str) -> Self {
        let rows = csv.lines().filter_map(|line| {
            let values: Vec<f64> = line.split(',').map_while(|field| field.trim().parse().ok()).collect();
            let columns: [f64; N] = values.get(1..=N)?.try_into().ok()?;
            Some((values[0], columns))
        });
        Self { rows: rows.collect() }
    }

    /// Linear interpolation at a wavelength in nm; zero outside the table.
    pub(crate) fn at(&self, wavelength_nm: f64) -> [f64; N] {
        let above = self.rows.partition_point(|(nm, _)| *nm <= wavelength_nm);
        match (above.checked_sub(1).map(|i| &self.rows[i]), self.rows.get(above)) {
            (Some((l0, y0)), Some((l1, y1))) => {
                let t = (wavelength_nm - l0) / (l1 - l0);
                std::array::from_fn(|i| y0[i] + t * (y1[i] - y0[i]))
            }
            (Some((l0, y0)), None) if *l0 == wavelength_nm => *y0,
            _ => [0.0; N],
        }
    }

    #[cfg(test)]
    pub(crate) fn len(&self) -> usize {
        self.rows.len()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tables_interpolate_linearly_and_vanish_outside() {
        let table = WavelengthTable::<2>::from_embedded("nm,a,b\n400,1,2\n410,3,6\n");
        assert_eq!(table.len(), 2);
        assert_eq!(table.at(405.0), [2.0, 4.0]);
        assert_eq!(table.at(400.0), [1.0, 2.0]);
        assert_eq!(table.at(410.0), [3.0, 6.0]);
        assert_eq!(table.at(399.9), [0.0, 0.0]);
        assert_eq!(table.at(410.1), [0.0, 0.0]);
    }
}
