// What the pixels of a block of 2 x 2 hand each other. A device shades them together, in step, so that
// v +- dFdx(v) is what v is in the pixel beside: an exchange costs a subtraction and an addition, and what the four
// have all loaded for themselves is loaded once. It is good to the last bits of the greater of the two.

// A ray as it is gathered. All is 0 for no ray.
struct Gathered {
    vec4 key;   // what its weight goes by; 0 in w for no ray, negative for a miss
    vec4 color; // of the hit, and its fade in a
};

// From a block's pixel to the outside of the block, along each axis: 1 or -1.
ivec2 Outward(ivec2 at) {
    return 2 * (at & 1) - 1;
}

// What the other pixel along an axis has. `outward` is that of the pixel that asks, along this axis.
Gathered AcrossX(Gathered r, int outward) {
    return Gathered(r.key - float(outward) * dFdxFine(r.key), r.color - float(outward) * dFdxFine(r.color));
}

Gathered AcrossY(Gathered r, int outward) {
    return Gathered(r.key - float(outward) * dFdyFine(r.key), r.color - float(outward) * dFdyFine(r.color));
}
