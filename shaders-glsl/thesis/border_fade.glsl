// The fade of hits near the screen's border (thesis 4.2.9, Eq. 4.7).

float BorderFade(vec2 R_intersection, float I_start, float I_end) {
    float D_boundary = length(R_intersection - vec2(0.5)) * 2.0;
    return 1.0 - max(0.0, min((D_boundary - I_start) / (I_end - I_start), 1.0));
}
