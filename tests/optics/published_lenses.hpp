// Parameters of real lenses, as published, each with its source and the seen radius that its users need.
#pragma once

#include <array>
#include <cmath>
#include <string>
#include <vector>

#include <holdfast/optics/lens.hpp>

namespace holdfast::test {

/// Knots of LibOVR 0.4, OVR_Stereo.cpp, GenerateLensConfigFromEyeRelief. Unit: tangents at the centre.
inline constexpr std::array<double, 11> dk2_knots{1.003, 1.02,  1.042, 1.066, 1.094, 1.126,
                                                  1.162, 1.203, 1.25,  1.31,  1.38};  // EyeCup_DK2A, both reliefs
inline constexpr std::array<double, 11> dk1_near_knots{1.0,   1.06505, 1.14725, 1.2705, 1.48, 1.87,
                                                       2.534, 3.6,     5.1,     7.4,    11.0};  // r_max^2 = 1.8
inline constexpr std::array<double, 11> dk1_middle_knots{1.0,       1.032407264, 1.07160462, 1.11998388,
                                                         1.1808606, 1.2590494,   1.361915,   1.5014339,
                                                         1.6986004, 1.9940577,   2.4783147};
inline constexpr std::array<double, 11> dk1_far_knots{1.0102, 1.0371, 1.0831, 1.1353, 1.2, 1.2851,
                                                      1.3979, 1.56,   1.8,    2.25,   3.0};

/// An HTC Vive's JSON, left eye, as kept in Monado's survive driver of 2020: k1, k2, k3 of each colour.
inline constexpr ViveCoefficients vive_red{-0.188236068524731, -0.07316590815739493, -0.02223805567703767, 0.0};
inline constexpr ViveCoefficients vive_green{-0.221086205321053, -0.02332400789561968, -0.04931309279533211, 0.0};
inline constexpr ViveCoefficients vive_blue{-0.2537849057915209, 0.02469959434698275, -0.07862881939243466, 0.0};

/// Monado's PS VR driver: distortion_k, in units of 1.2 times half the eye's picture width; red 0.999, blue 1.018.
inline constexpr std::array<double, 5> psvr{0.75, -0.01, 0.75, 0.0, 3.8};

/// OSVR's descriptors: polynomial_coeffs_green without the leading a0 = 0.
inline constexpr std::array<double, 2> osvr_dk2{1.0, 0.24};
inline constexpr std::array<double, 9> osvr_hdk_1_1{1.0, 0.0, 0.5, 0.0, -1.15, 0.0, 9.25, 0.0, -5.0};

/// EuRoC MAV dataset, cam0 (radial-tangential, 752 x 480, focal length 458 px): k1, k2, p1, p2.
inline constexpr BrownConradyCoefficients euroc{-0.28340811, 0.07395907, 0.00019359, 1.76187114e-05};
/// An Azure Kinect's depth camera, from Azure-Kinect-Sensor-SDK issue 1518 (rational, focal length 0.4927 of 1024 px).
inline constexpr BrownConradyCoefficients azure_kinect{
    0.92184948921203613,  0.50040090084075928, -3.0782209705648711e-6, 2.7718663204723271e-6,
    0.028360467404127121, 1.2584241628646851,  0.75181210041046143,    0.14418977499008179};
/// TUM-VI dataset, cam0 at 512 x 512 (focal length 191 px).
inline constexpr KannalaBrandtLens::Coefficients tum_vi{0.0034823894022493434, 0.0007150348452162257,
                                                        -0.0020532361418706202, 0.00020293673591811182};

/// Project North Star, documentation of calibration v2, the example DisplayCalibration.json.
inline constexpr std::array<double, 16> north_star_left_x{
    -0.7098117476732205,  1.2394941892905988,   -0.48417252984476766, 0.20206420448436016,
    0.03418806429705912,  0.31907410136307673,  -0.4605158142547907,  0.4042603873520616,
    -0.18943883499730696, 0.48132219553953726,  -0.30879967889089477, -0.13741429189104715,
    0.07547417258600822,  -0.19519320096721232, 0.2613765880648765,   0.06086994286421869};
inline constexpr std::array<double, 16> north_star_left_y{
    -0.4743021475999604, 0.5369044594256003,  -0.8525771689196032, 0.2627710079276929,
    1.3652046041682682,  -2.201384532354616,  3.4438400605675517,  -1.7580162263564094,
    -0.8231665571360403, 3.044993768618694,   -5.194290634899861,  2.77812666747202,
    0.5755243231226848,  -1.6224283568386757, 2.574297012238049,   -1.3553329073119127};
inline constexpr std::array<double, 16> north_star_right_x{
    -0.7183962692213749,  1.6919128983783627,  -0.8959084856794854, 0.5118720577498754,
    -0.15182574964167417, 0.1745194186629323,  -0.7785485023972123, 0.23327978620674053,
    0.3893135920142324,   -1.5912429984917236, 2.734216996517882,   -1.1734819917912498,
    -0.2990328028712862,  1.1872834177169778,  -1.85802686141548,   0.8196605383643771};
inline constexpr std::array<double, 16> north_star_right_y{
    -0.33744873551124743, 0.1047649025161288,  0.013610912044989515, 0.1786419445104183,
    1.192716575734179,    -0.8489132518356299, 1.2156256513013421,   -0.7183342093015473,
    -0.606833960145091,   1.6425190844725888,  -3.229817903076172,   2.1586459013997885,
    0.5037473982889102,   -1.4667773614252788, 2.9192654996404515,   -1.8710955978153174};

struct PublishedLens {
  std::string name;
  Lens lens;
  double seen_radius;  ///< in tangents: what its users see, or the domain if that is smaller
  bool radial = true;
};

/// One lens of every model, placed as its headset has it (a camera: as if a display had been calibrated so; where the
/// unit is half of a picture's width, that is taken for a tangent of about 1).
inline std::vector<PublishedLens> published_lenses() {
  const auto even = [](std::vector<double> k, double k0 = 1.0) { return PolynomialLens(k, k0); };
  const auto spline = [](const std::array<double, 11>& knots, double r_max, std::array<double, 2> chroma = {0.0, 0.0}) {
    return CatmullRomLens({knots, r_max, chroma});
  };
  std::vector<PublishedLens> all;
  all.push_back({"Flight Helmet, course 11 table 8.1", Lens(RadialLens{0.1933}, placed_at(0.504)), 1.5});
  all.push_back({"Cardboard I/O 2014 (v1), Google's viewer profile", even({0.441, 0.156}), 2.0});
  all.push_back({"Cardboard I/O 2015 (v2), Google's viewer profile", even({0.34, 0.55}), 2.0});
  all.push_back({"Oculus DK1, SDK 0.2 distortionK", Lens(even({0.22, 0.24}), placed_at(0.913, {0.15, 0.0})), 2.0});
  all.push_back(
      {"Oculus DK1, SDK 0.2, red: chroma 0.996, -0.004",
       Lens(even({0.22 * 0.996 - 0.004, 0.24 * 0.996 - 0.22 * 0.004, -0.24 * 0.004}, 0.996), placed_at(0.913)), 2.0});
  all.push_back({"OSVR's DK2", Lens(PowerSeriesLens(osvr_dk2), placed_at(0.9)), 1.5});
  all.push_back({"OSVR HDK 1.1", Lens(PowerSeriesLens(osvr_hdk_1_1), placed_at(1.0)), 1.5});
  all.push_back({"PS VR, Monado (Panotools)", Lens(PowerSeriesLens(psvr), placed_at(1.2)), 1.5});
  all.push_back({"HTC Vive red", Lens(ViveLens(vive_red), placed_at(1.0, {0.089, -0.009})), 2.0});
  all.push_back({"HTC Vive green", Lens(ViveLens(vive_green), placed_at(1.0, {0.089, -0.009})), 2.0});
  all.push_back({"HTC Vive blue", Lens(ViveLens(vive_blue), placed_at(1.0, {0.089, -0.009})), 2.0});
  all.push_back({"Oculus DK2 green, LibOVR 0.4", spline(dk2_knots, 1.0), 2.0});
  all.push_back({"Oculus DK2 red, relief 8 mm", spline(dk2_knots, 1.0, {-0.0112, -0.015}), 2.0});
  all.push_back({"Oculus DK2 blue, relief 18 mm", spline(dk2_knots, 1.0, {0.025, 0.02}), 2.0});
  all.push_back({"Oculus DK1, smallest relief", spline(dk1_near_knots, std::sqrt(1.8)), 5.0});
  all.push_back({"Oculus DK1, greatest relief", spline(dk1_far_knots, 1.0), 3.0});
  all.push_back({"TUM-VI cam0 (Kannala-Brandt)", KannalaBrandtLens(tum_vi), 20.0});
  all.push_back({"EuRoC cam0 (Brown-Conrady), panel to seen", BrownConradyLens(euroc), 1.0, false});
  all.push_back({"EuRoC cam0 (Brown-Conrady), seen to panel, y down",
                 Lens(ReversedLens(BrownConradyLens(euroc)), {{0.02, -0.01}, {1.0, -1.0}}), 1.0, false});
  all.push_back({"Azure Kinect (rational), seen to panel", ReversedLens(BrownConradyLens(azure_kinect)), 2.0, false});
  all.push_back({"Azure Kinect (rational), panel to seen", BrownConradyLens(azure_kinect), 1.0, false});
  all.push_back(
      {"North Star left", BivariateLens(north_star_eye(north_star_left_x, north_star_left_y)->lens), 0.7, false});
  all.push_back(
      {"North Star right", BivariateLens(north_star_eye(north_star_right_x, north_star_right_y)->lens), 0.7, false});
  for (PublishedLens& p : all) p.seen_radius = std::min(p.seen_radius, p.lens.valid_image_radius() * (1 - 1e-12));
  return all;
}

}  // namespace holdfast::test
