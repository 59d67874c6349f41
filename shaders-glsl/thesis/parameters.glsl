// Parameters of the thesis's passes, beside the constants of linear_ray_march.glsl. The presets `published` and `author`
// fill them (src/methods/thesis.rs says which value comes from where).

layout(std140, binding = 0) uniform ThesisBlock {
    mat4 projection;               // M_proj: view to clip, standard depth
    mat4 inverse_projection;       // M_proj^-1
    vec2 resolution;               // pixels
    float near_plane;              // metres
    float far_plane;
    float reflection_offset;       // epsilon of Alg. 2, metres
    float view_direction_epsilon;  // epsilon of Alg. 6
    float cross_offset;            // pixels that a ray is pushed past a boundary
    int start_level;               // of the Hi-Z traversal
    int max_level;                 // coarsest Hi-Z level
    int iterations;                // bound of the Hi-Z traversal
    float linear_march_stride;     // first step, in screen space
    float binary_search_first;     // first step, in units of the march's stride
    int cone_samples;              // circles of the cone
    int cone_lengthened;           // 1: the first triangle is lengthened by its base
    int cone_interpolated;         // 1: alpha of Eq. 4.5 is interpolated between the next two
    float cone_alpha_min;          // alpha at roughness 1
    float cone_alpha_max;          // alpha at roughness 0
    float cone_xi;                 // xi of Eq. 4.5
    float cone_mirror_alpha;       // an interpolated alpha above it is a mirror's
    float fade_start;              // I_start of Eq. 4.7
    float fade_end;                // I_end of Eq. 4.7
    float fade_towards_camera;     // hzct: factor of its fade; 0: none
    int fade;                      // 0: no fade at all
    float uniform_stride_min;      // sslr: step at roughness 0, in screen space
    float uniform_stride_max;      // sslr: step at roughness 1
    float uniform_march_back;      // sslr: share of the last step that the hit goes back by
} thesis;
