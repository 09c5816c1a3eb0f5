//! Normals of a triangle mesh.

/// Outward unit normals at the vertices of a triangle mesh: area-weighted means of the normals of the
/// adjacent triangles; zero for a vertex without triangles.
pub fn vertex_normals(vertices: &[[f64; 3]], triangles: &[[u32; 3]]) -> Vec<[f64; 3]> {
    let mut normals = vec![[0.0; 3]; vertices.len()];
    for triangle in triangles {
        let [a, b, c] = triangle.map(|v| vertices[v as usize]);
        let [u, v]: [[f64; 3]; 2] = [b, c].map(|p| std::array::from_fn(|i| p[i] - a[i]));
        // Its length is twice the area of the triangle.
        let cross = [
            u[1] * v[2] - u[2] * v[1],
            u[2] * v[0] - u[0] * v[2],
            u[0] * v[1] - u[1] * v[0],
        ];
        for &corner in triangle {
            for (sum, part) in normals[corner as usize].iter_mut().zip(cross) {
                *sum += part;
            }
        }
    }
    let unit = |n: [f64; 3]| {
        let length = n.iter().map(|c| c * c).sum::<f64>().sqrt();
        n.map(|c| c / length.max(f64::MIN_POSITIVE))
    };
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
