// The pyramid: cell (x, y) of level n covers exactly the pixels (i, j) with i >> n = x, j >> n = y.
// It holds their nearest front and their farthest back in reversed depth, so that the closed
// interval [back, front] bounds every block in it; a cell without geometry is empty.
//
// All levels stand in one image, one below the other: level n begins at row
// rows - (rows >> n), with rows = twice the padded height. So a cell's texel takes a shift and an
// addition, whatever its level, and no device has to look up a mip level for each thread. Passes load
// it as an image of one level: nothing of it is ever filtered.

const vec2 EMPTY_BLOCK = vec2(-1.0, 2.0); // front below every depth, back above

int PyramidRows() {
    return 2 * unified.padded.y;
}

ivec2 CellTexel(ivec2 cell, int level) {
    int rows = PyramidRows();
    return ivec2(cell.x, cell.y + rows - (rows >> level));
}
