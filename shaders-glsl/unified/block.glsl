// What the pixels of a block of 2 x 2 hand each other. A device shades them together, in step, so that
// v +- dFdx(v) is what v is in the pixel beside: an exchange costs a subtraction and an addition, and what the four
// have all loaded for themselves is loaded once. It is good to the last bits of the greater of the two.

// From a block's pixel to the outside of the block, along each axis: 1 or -1.
ivec2 Outward(ivec2 at) {
    return 2 * (at & 1) - 1;
}

// Of the other pixel along an axis. `outward` is that of the pixel that asks, along this axis.
float AcrossX(float v, int outward) {
    return v - float(outward) * dFdxFine(v);
}

vec3 AcrossX(vec3 v, int outward) {
    return v - float(outward) * dFdxFine(v);
}

vec4 AcrossX(vec4 v, int outward) {
    return v - float(outward) * dFdxFine(v);
}

float AcrossY(float v, int outward) {
    return v - float(outward) * dFdyFine(v);
}

vec3 AcrossY(vec3 v, int outward) {
    return v - float(outward) * dFdyFine(v);
}

vec4 AcrossY(vec4 v, int outward) {
    return v - float(outward) * dFdyFine(v);
}
