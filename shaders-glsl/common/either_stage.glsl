// Macros that make one source a fragment program over whole targets and a compute program, a thread a texel. A source
// with `#pragma in_either_stage` is compiled for both stages, with COMPUTE defined for compute. The source declares its
// outputs by OUTPUT, gets its position from PIXEL_CENTRE, and has the body of its main function after SHADE. It takes
// no derivatives and samples no implicit level of detail, which compute programs do not have.

#ifndef COMMON_EITHER_STAGE_GLSL
#define COMMON_EITHER_STAGE_GLSL

#ifdef COMPUTE

#include "common/constants.glsl"

layout(local_size_x = GROUP_SIDE, local_size_y = GROUP_SIDE) in;

// The centre of the thread's texel, in pixels: what gl_FragCoord.xy is to a fragment program.
#define PIXEL_CENTRE (vec2(gl_GlobalInvocationID.xy) + 0.5)

// A source that writes a slice of a volume defines both macros itself.
#ifndef OUTPUT_IMAGE
#define OUTPUT_IMAGE image2D
#define OUTPUT_TEXEL ivec2(gl_GlobalInvocationID.xy)
#endif

// Declares an output: its number, the format of its image, its type and its name. All other bindings have lower
// numbers.
#define OUTPUT(number, format, type, name) \
    layout(binding = FIRST_OUTPUT + number, format) uniform writeonly OUTPUT_IMAGE name##_image; \
    type name
#define OUTPUT_UINT(number, format, name) \
    layout(binding = FIRST_OUTPUT + number, format) uniform writeonly uimage2D name##_image; \
    uint name

bool discarded = false;
// Ends the function and leaves the texel as it is.
#define DISCARD { discarded = true; return; }

// ToTexel converts the value of an output to the four components that imageStore takes.
vec4 ToTexel(float value) {
    return vec4(value);
}

vec4 ToTexel(vec2 value) {
    return vec4(value, 0.0, 0.0);
}

vec4 ToTexel(vec4 value) {
    return value;
}

uvec4 ToTexel(uint value) {
    return uvec4(value);
}

// Stores a further output, as an argument of SHADE_ALL.
#define STORE(name) imageStore(name##_image, OUTPUT_TEXEL, ToTexel(name));
#define STORE_IF(wanted, name) if (wanted) STORE(name)

// Begins the main function of a source with several outputs: `first` is the first of them, and `others` stores the
// rest. A thread beyond the border of the image does nothing.
#define SHADE_ALL(first, others) \
    void Shade(); \
    void main() { \
        if (any(greaterThanEqual(ivec2(gl_GlobalInvocationID.xy), imageSize(first##_image).xy))) \
            return; \
        Shade(); \
        if (discarded) \
            return; \
        STORE(first) \
        others \
    } \
    void Shade()
#define SHADE(output) SHADE_ALL(output, ;)

#else

#define PIXEL_CENTRE gl_FragCoord.xy
#define OUTPUT(number, format, type, name) layout(location = number) out type name
#define OUTPUT_UINT(number, format, name) layout(location = number) out uint name
#define DISCARD discard
#define SHADE_ALL(first, others) void main()
#define SHADE(output) void main()

#endif

#endif
