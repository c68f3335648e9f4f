//! Linear BT.709 with white D65: from CIE XYZ and back.

/// Chromaticities x, y of the red, green and blue primaries (ITU-R BT.709-6, table 1, item 1.3).
pub const BT709_PRIMARIES: [[f64; 2]; 3] = [[0.64, 0.33], [0.30, 0.60], [0.15, 0.06]];

/// Chromaticity of the white point D65 (ITU-R BT.709-6, table 1, item 1.4).
pub const BT709_WHITE: [f64; 2] = [0.3127, 0.3290];

/// Luminance of linear BT.709 channels (ITU-R BT.709-6, table 1, item 3.2).
pub const BT709_LUMINANCE: [f64; 3] = [0.2126, 0.7152, 0.0722];

/// A 3 by 3 matrix, by rows.
pub type Matrix3 = [[f64; 3]; 3];

/// Product of a matrix and a column.
pub fn apply(matrix: &Matrix3, v: [f64; 3]) -> [f64; 3] {
    std::array::from_fn(|i| matrix[i][0] * v[0] + matrix[i][1] * v[1] + matrix[i][2] * v[2])
}

/// Inverse of a matrix; `None` where it is singular to rounding.
pub fn inverse(m: &Matrix3) -> Option<Matrix3> {
    let cofactor = |i: usize, j: usize| {
        let (a, b, c, d) = ((i + 1) % 3, (i + 2) % 3, (j + 1) % 3, (j + 2) % 3);
        m[a][c] * m[b][d] - m[a][d] * m[b][c]
    };
    let det = (0..3).map(|j| m[0][j] * cofactor(0, j)).sum::<f64>();
    let scale = m.iter().map(|row| row.iter().map(|v| v * v).sum::<f64>().sqrt()).product::<f64>();
    // Below 1e-10 of the product of the row lengths the rows are parallel to the accuracy of the colour data.
    (det.abs() > 1e-10 * scale).then(|| std::array::from_fn(|i| std::array::from_fn(|j| cofactor(j, i) / det)))
}

/// The matrix that takes linear BT.709 to XYZ, white having Y = 1 (SMPTE RP 177-1993, section 3.3).
pub fn xyz_from_bt709() -> Matrix3 {
    let column = |[x, y]: [f64; 2]| [x / y, 1.0, (1.0 - x - y) / y];
    let primaries = BT709_PRIMARIES.map(column);
    let unscaled: Matrix3 = std::array::from_fn(|i| std::array::from_fn(|j| primaries[j][i]));
    let scale = inverse(&unscaled).map_or([1.0; 3], |inverse| apply(&inverse, column(BT709_WHITE)));
    std::array::from_fn(|i| std::array::from_fn(|j| unscaled[i][j] * scale[j]))
}

/// The matrix that takes XYZ to linear BT.709.
pub fn bt709_from_xyz() -> Matrix3 {
    // The primaries span a triangle, so the inverse exists.
    inverse(&xyz_from_bt709()).unwrap_or([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_matrix_is_that_of_the_standard() {
        let m = xyz_from_bt709();
        let published = [[0.4124, 0.3576, 0.1805], BT709_LUMINANCE, [0.0193, 0.1192, 0.9505]];
        for (row, published) in m.iter().zip(published) {
            for (value, published) in row.iter().zip(published) {
                assert!((value - published).abs() < 6e-5, "{value} {published}");
            }
        }
    }

    #[test]
    fn d65_is_white() {
        let [x, y] = BT709_WHITE;
        for channel in apply(&bt709_from_xyz(), [x / y, 1.0, (1.0 - x - y) / y]) {
            assert!((channel - 1.0).abs() < 1e-12);
        }
    }

    #[test]
    fn a_singular_matrix_has_no_inverse() {
        assert_eq!(inverse(&[[1.0, 2.0, 3.0], [2.0, 4.0, 6.0], [0.0, 0.0, 1.0]]), None);
    }
}
