// The fade of hits near the screen's border (thesis 4.2.9, Eq. 4.7), whose I_end is 1 and whose I_start is 0.8 "in the demo".

// Print: §4.2.9, Eq. 4.7.
// 1, 2: I_end = 1, I_start in (0, I_end]
float BorderFade(vec2 R_intersection, float I_start, float I_end) {
    // 3: D_boundary = |R_intersection - (0.5, 0.5)| * 2
    float D_boundary = length(R_intersection - vec2(0.5)) * 2.0;
    // 4: f_border = 1 - max(0, min((D_boundary - I_start) / (I_end - I_start), 1))
    return 1.0 - max(0.0, min((D_boundary - I_start) / (I_end - I_start), 1.0));
}
