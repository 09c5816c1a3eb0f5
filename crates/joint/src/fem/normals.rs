//! Normals of a triangle mesh.

use crate::vector::{add_scaled, cross, norm, scale};

/// Outward unit normals at the vertices of a triangle mesh: area-weighted means of the normals of the
/// adjacent triangles; zero for a vertex without triangles.
pub fn vertex_normals(vertices: &[[f64; 3]], triangles: &[[u32; 3]]) -> Vec<[f64; 3]> {
    let mut normals = vec![[0.0; 3]; vertices.len()];
    for triangle in triangles {
        let [a, b, c] = triangle.map(|v| vertices[v as usize]);
        // Its length is twice the area of the triangle.
        let cross = cross(add_scaled(b, -1.0, a), add_scaled(c, -1.0, a));
        for corner in triangle.map(|v| v as usize) {
            normals[corner] = add_scaled(normals[corner], 1.0, cross);
        }
    }
    let unit = |n| scale(n, 1.0 / norm(n).max(f64::MIN_POSITIVE));
    normals.into_iter().map(unit).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn normals_of_a_tetrahedron_point_outwards() {
        let vertices = [
            [1.0, 1.0, 1.0],
            [1.0, -1.0, -1.0],
            [-1.0, 1.0, -1.0],
            [-1.0, -1.0, 1.0],
        ];
        let triangles = [[0, 1, 2], [0, 3, 1], [0, 2, 3], [1, 3, 2]];
        for (normal, vertex) in vertex_normals(&vertices, &triangles).iter().zip(&vertices) {
            let cosine: f64 = (0..3).map(|i| normal[i] * vertex[i]).sum();
            assert!((cosine / 3f64.sqrt() - 1.0).abs() < 1e-12);
        }
    }
}
