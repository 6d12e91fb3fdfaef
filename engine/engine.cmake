# The in-house engine, and its worker.
add_library(atwood_engine STATIC
  simulation.cpp
  parallel/team.cpp
  fluid/body_acceleration.cpp
  fluid/body_overlaps.cpp
  fluid/corrections.cpp
  fluid/kernel.cpp
  fluid/kick_drift.cpp
  fluid/law.cpp
  fluid/neighbours.cpp
  fluid/options.cpp
  fluid/particle_set.cpp
  fluid/polynomial.cpp
  fluid/polynomial_fit.cpp
  fluid/polynomial_nodes.cpp
  fluid/polynomial_surface.cpp
  fluid/polynomial_walls.cpp
  fluid/run.cpp
  fluid/sph.cpp
  fluid/spectrum.cpp
  fluid/stability.cpp
  fluid/sums.cpp
  fluid/transport.cpp
  fluid/walls.cpp
  smooth/prepare.cpp
  smooth/run.cpp
  smooth/stops.cpp
  math/elementary.cpp
  math/elliptic.cpp
  math/principal_axes.cpp
  math/scalar.cpp
  math/vector_width.cpp
  joints/closing_force.cpp
  joints/constraint.cpp
  joints/constraints.cpp
  joints/constraints_rows.cpp
  joints/derivatives.cpp
  joints/differences.cpp
  joints/joint_forces.cpp
  joints/mass_matrix.cpp
  joints/planar_rates.cpp
  joints/planar_loops.cpp
  joints/planar_loops_wide.cpp
  joints/rope.cpp
  joints/symmetric_corrections.cpp
  joints/tree.cpp
  joints/tree_dynamics.cpp
  joints/tree_motion.cpp
  joints/tree_rates.cpp
  rigid/bare_problems.cpp
  rigid/energy.cpp
  rigid/free_top.cpp
  rigid/free_top_exact.cpp
  rigid/free_top_implicit.cpp
  rigid/mechanism.cpp
  rigid/mechanism_constraints.cpp
  rigid/joint_rates.cpp
  rigid/model.cpp
  rigid/rate.cpp
  rigid/rate_lanes.cpp
  forces/attractor.cpp
  forces/conservative.cpp
  forces/coulomb.cpp
  forces/drive.cpp
  forces/gravity_many.cpp
  forces/gravity_pairs.cpp
  forces/gravity_tree.cpp
  forces/gravity_tree_build.cpp
  forces/linear_drag.cpp
  forces/lorentz.cpp
  forces/mutual_gravity.cpp
  forces/point_force.cpp
  forces/potential.cpp
  forces/quadratic_drag.cpp
  forces/rotating_frame.cpp
  forces/series_forces.cpp
  forces/spring.cpp
  forces/thruster.cpp
  integrators/adaptive.cpp
  integrators/catalogue.cpp
  integrators/collocation_nodes.cpp
  integrators/composition_methods.cpp
  integrators/compositions.cpp
  integrators/conserving_correction.cpp
  integrators/conserving_gradient.cpp
  integrators/conserving_methods.cpp
  integrators/constrained_methods.cpp
  integrators/explicit_methods.cpp
  integrators/extrapolation.cpp
  integrators/formulas.cpp
  integrators/free_flight.cpp
  integrators/free_flight_alone.cpp
  integrators/free_flight_lanes.cpp
  integrators/high_precision_methods.cpp
  integrators/implicit_alpha.cpp
  integrators/implicit_methods.cpp
  integrators/implicit_runge_kutta.cpp
  integrators/implicit_solver.cpp
  integrators/implicit_stages.cpp
  integrators/implicit_tableaux.cpp
  integrators/kick_drift.cpp
  integrators/maximal_coordinates.cpp
  integrators/multistep.cpp
  integrators/multistep_methods.cpp
  integrators/multistep_tables.cpp
  integrators/nystrom.cpp
  integrators/nystrom_methods.cpp
  integrators/nystrom_tables.cpp
  integrators/partitioned.cpp
  integrators/partitioned_methods.cpp
  integrators/radau15.cpp
  integrators/radau15_point_masses.cpp
  integrators/radau15_table.cpp
  integrators/responses.cpp
  integrators/rotation_lie.cpp
  integrators/rotation_methods.cpp
  integrators/runge_kutta.cpp
  integrators/stepper.cpp
  integrators/symmetric_projection.cpp
  integrators/tableaux.cpp
  integrators/tableaux_low_order.cpp
  integrators/tableaux_order_7_8.cpp
  integrators/tableaux_pairs.cpp
  integrators/tableaux_verner.cpp
  integrators/taylor.cpp)
target_compile_options(atwood_engine PRIVATE -Wno-psabi)  # math/pack.hpp
atwood_precompile_headers(atwood_engine)
target_include_directories(atwood_engine PUBLIC ${CMAKE_CURRENT_LIST_DIR})
target_link_libraries(atwood_engine PUBLIC atwood_scene atwood_protocol PRIVATE quadmath atwood_eigen)

include(${CMAKE_CURRENT_LIST_DIR}/contact/contact.cmake)  # collision/ and contact/ list their own sources

# The files whose templates take long to compile stand alone, so that the processors share the work.
set_target_properties(atwood_engine PROPERTIES UNITY_BUILD ${ATWOOD_UNITY_BUILD} UNITY_BUILD_BATCH_SIZE 9)
set_source_files_properties(
  contact/event/event.cpp contact/event/impulse_newton.cpp contact/penalty.cpp contact/stepping/manifold_contacts.cpp
  contact/stepping/run.cpp contact/stepping/sphere_contacts.cpp fluid/neighbours.cpp fluid/polynomial.cpp
  fluid/polynomial_fit.cpp fluid/run.cpp fluid/spectrum.cpp fluid/sph.cpp fluid/sums.cpp fluid/transport.cpp
  integrators/conserving_correction.cpp integrators/free_flight_alone.cpp integrators/free_flight_lanes.cpp
  integrators/maximal_coordinates.cpp integrators/radau15_point_masses.cpp
  integrators/radau15.cpp integrators/runge_kutta.cpp integrators/symmetric_projection.cpp integrators/taylor.cpp joints/closing_force.cpp
  joints/constraints.cpp
  joints/constraints_rows.cpp joints/derivatives.cpp joints/differences.cpp joints/planar_loops.cpp
  joints/planar_loops_wide.cpp joints/symmetric_corrections.cpp joints/tree.cpp joints/tree_dynamics.cpp joints/tree_motion.cpp
  joints/planar_rates.cpp joints/tree_rates.cpp rigid/mechanism.cpp rigid/model.cpp rigid/rate_lanes.cpp smooth/prepare.cpp smooth/run.cpp
  PROPERTIES SKIP_UNITY_BUILD_INCLUSION ON)
# A load of two components that were stored one by one waits for both stores: in the passes over links that costs 10 to 20 %
# more than what joining them gains. (A compiler's precompiled header is of one set of options.)
set_source_files_properties(
  joints/constraints.cpp joints/constraints_rows.cpp joints/planar_loops.cpp joints/planar_rates.cpp joints/tree.cpp
  joints/tree_dynamics.cpp joints/tree_motion.cpp joints/tree_rates.cpp
  PROPERTIES COMPILE_OPTIONS -fno-tree-slp-vectorize SKIP_PRECOMPILE_HEADERS ON)
# Its names (pair, stages, boris) are those of other files.
set_source_files_properties(integrators/formulas.cpp PROPERTIES SKIP_UNITY_BUILD_INCLUSION ON)

add_executable(atwood-engine worker_main.cpp)
target_link_libraries(atwood-engine PRIVATE atwood_engine)
set_target_properties(atwood-engine PROPERTIES RUNTIME_OUTPUT_DIRECTORY ${CMAKE_BINARY_DIR}/bin)

# What `atwood derivatives` asks: a scene on standard input, derivatives as CSV on standard output.
add_executable(atwood-derivatives derivatives_main.cpp)
target_link_libraries(atwood-derivatives PRIVATE atwood_engine quadmath)
set_target_properties(atwood-derivatives PROPERTIES RUNTIME_OUTPUT_DIRECTORY ${CMAKE_BINARY_DIR}/bin)
