// Deployment of the stub: half a recorded flight, SAVE; a new component, RESTORE, the other half.
#include "InertiaEstimator.hpp"

namespace {

#define ROW(t, x, y, z, a, b, c, d, l, m, n) {t, {x, y, z}, {a, b, c, d}, {l, m, n}},
Gnc::GyroSample flight[] = {
#include "../../flights/wheel_slew.inc"
};
#undef ROW
constexpr size_t LENGTH = sizeof flight / sizeof flight[0];

// Cycles of the rate group: ten samples each.
void fly(Gnc::InertiaEstimator& component, size_t from, size_t end) {
    for (size_t k = from; k < end; k++) {
        component.sample(flight[k]);
        if (k % 10 == 0 || k + 1 == end) {
            component.cycle();
        }
    }
}

fsw_window_config craft() {
    static const float signs[4][2] = {{1, 1}, {-1, 1}, {-1, -1}, {1, -1}};
    fsw_window_config config = {};
    config.struct_size = sizeof config;
    (void)fsw_window_config_defaults(&config, 1e-4f);
    for (int i = 0; i < 4; i++) {
        config.wheels.axis[i][0] = signs[i][0];
        config.wheels.axis[i][1] = signs[i][1];
        config.wheels.axis[i][2] = 1;
        config.wheels.spin_inertia_kg_m2[i] = 2.1e-5f;
    }
    config.slices_per_step = 1;
    return config;
}

}  // namespace

int main() {
    static Gnc::InertiaEstimator first("inertia"), second("inertia");
    if (!first.configure(craft()) || !second.configure(craft())) {
        return 1;
    }
    fly(first, 0, LENGTH / 2);
    first.save();
    second.restore();
    fly(second, LENGTH / 2, LENGTH);
    return 0;
}
