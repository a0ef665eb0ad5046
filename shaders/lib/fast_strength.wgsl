// FAST-9/16 (Rosten and Drummond 2005). Twin: src/percept/capture/fast.rs.

// Largest over the sixteen arcs of nine and both signs of the smallest |difference|: the pixel is a
// corner at threshold t where this exceeds t, and its score is one less. `difference` holds ring
// minus centre, clockwise from the top.
fn fast_strength_of(difference: array<i32, 16>) -> u32 {
    var ring = difference;
    var best = 0;
    for (var start = 0u; start < 16u; start++) {
        var low = ring[start];
        var high = low;
        for (var k = 1u; k < 9u; k++) {
            let d = ring[(start + k) & 15u];
            low = min(low, d);
            high = max(high, d);
        }
        best = max(best, max(low, -high));
    }
    return u32(best);
}
