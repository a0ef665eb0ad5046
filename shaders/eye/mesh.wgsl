// The vertex stage of what is drawn where its mesh stands.

@vertex
fn vertex(in: VertexIn) -> Surface {
    return surface_at(in, in.position, camera_from(in.instance));
}
