// GLSL's vectors and functions for C++, over floats or lanes of floats: the part that shaders/kernel uses.
#pragma once

#include <cmath>
#include <type_traits>

#include "engine/kernels/lanes.h"
#include "support/angle.h"

namespace paradesc::kernels {
inline namespace KERNEL_TARGET {

// ---- Single numbers

inline float abs(float x) { return std::fabs(x); }
inline float min(float a, float b) { return b < a ? b : a; }
inline float max(float a, float b) { return a < b ? b : a; }
inline float sqrt(float x) { return std::sqrt(x); }
inline float exp(float x) { return std::exp(x); }
inline float atan(float y, float x) { return static_cast<float>(angle_of(y, x)); }
inline bool isnan(float x) { return std::isnan(x); }
// Like GLSL's mix: returns the second value if the choice is true.
inline float mix(float a, float b, bool choice) { return choice ? b : a; }

template <class T> T inversesqrt(T x) { return 1.0f / sqrt(x); }
template <class T> T clamp(T x, std::type_identity_t<T> low, std::type_identity_t<T> high) { return min(max(x, low), high); }
template <class T> T smoothstep(std::type_identity_t<T> low, std::type_identity_t<T> high, T x) {
  const T t = clamp((x - low) / (high - low), 0.0f, 1.0f);
  return t * t * (3.0f - 2.0f * t);
}

// ---- Vectors

template <int size, class T> struct Vector;
template <class T> struct Vector<2, T> {
  T x, y;
  Vector() = default;
  explicit Vector(T all) : x(all), y(all) {}
  Vector(T x_, T y_) : x(x_), y(y_) {}
};
template <class T> struct Vector<3, T> {
  T x, y, z;
  Vector() = default;
  explicit Vector(T all) : x(all), y(all), z(all) {}
  Vector(T x_, T y_, T z_) : x(x_), y(y_), z(z_) {}
};
template <class T> struct Vector<4, T> {
  T x, y, z, w;
  Vector() = default;
  explicit Vector(T all) : x(all), y(all), z(all), w(all) {}
  Vector(T x_, T y_, T z_, T w_) : x(x_), y(y_), z(z_), w(w_) {}
};

// Component by component.
template <class T, class Of> Vector<2, T> each(const Vector<2, T> &a, const Vector<2, T> &b, const Of &of) {
  return {of(a.x, b.x), of(a.y, b.y)};
}
template <class T, class Of> Vector<3, T> each(const Vector<3, T> &a, const Vector<3, T> &b, const Of &of) {
  return {of(a.x, b.x), of(a.y, b.y), of(a.z, b.z)};
}
template <class T, class Of> Vector<4, T> each(const Vector<4, T> &a, const Vector<4, T> &b, const Of &of) {
  return {of(a.x, b.x), of(a.y, b.y), of(a.z, b.z), of(a.w, b.w)};
}

#define PARADESC_VECTOR_OPERATOR(op)                                                                                             \
  template <int n, class T> Vector<n, T> operator op(const Vector<n, T> &a, const Vector<n, T> &b) {                             \
    return each(a, b, [](const T &x, const T &y) { return x op y; });                                                            \
  }                                                                                                                              \
  template <int n, class T> Vector<n, T> operator op(const Vector<n, T> &a, const std::type_identity_t<T> &b) {                  \
    return a op Vector<n, T>(b);                                                                                                 \
  }                                                                                                                              \
  template <int n, class T> Vector<n, T> operator op(const std::type_identity_t<T> &a, const Vector<n, T> &b) {                  \
    return Vector<n, T>(a) op b;                                                                                                 \
  }                                                                                                                              \
  template <int n, class T> Vector<n, T> &operator op##=(Vector<n, T> &a, const Vector<n, T> &b) { return a = a op b; }          \
  template <int n, class T> Vector<n, T> &operator op##=(Vector<n, T> &a, const std::type_identity_t<T> &b) { return a = a op b; }
PARADESC_VECTOR_OPERATOR(+)
PARADESC_VECTOR_OPERATOR(-)
PARADESC_VECTOR_OPERATOR(*)
PARADESC_VECTOR_OPERATOR(/)
#undef PARADESC_VECTOR_OPERATOR

template <int n, class T> Vector<n, T> operator-(const Vector<n, T> &a) { return a * T(-1.0f); }
template <int n, class T> Vector<n, T> abs(const Vector<n, T> &a) {
  return each(a, a, [](const T &x, const T &) { return abs(x); });
}
template <class T> T dot(const Vector<2, T> &a, const Vector<2, T> &b) { return a.x * b.x + a.y * b.y; }
template <class T> T dot(const Vector<3, T> &a, const Vector<3, T> &b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
template <class T> T dot(const Vector<4, T> &a, const Vector<4, T> &b) {
  return a.x * b.x + a.y * b.y + a.z * b.z + a.w * b.w;
}
template <class T> Vector<3, T> cross(const Vector<3, T> &a, const Vector<3, T> &b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
template <int n, class T> T length(const Vector<n, T> &a) { return sqrt(dot(a, a)); }
template <int n, class T> Vector<n, T> normalize(const Vector<n, T> &a) { return a / length(a); }

// ---- Matrices, by columns

template <class T> struct Matrix3 {
  Vector<3, T> a, b, c;
  Matrix3(const Vector<3, T> &a_, const Vector<3, T> &b_, const Vector<3, T> &c_) : a(a_), b(b_), c(c_) {}
};
template <class T> Matrix3<T> operator/(const Matrix3<T> &m, const std::type_identity_t<T> &s) { return {m.a / s, m.b / s, m.c / s}; }
template <class T> Matrix3<T> operator-(const Matrix3<T> &m, const Matrix3<T> &n) { return {m.a - n.a, m.b - n.b, m.c - n.c}; }
template <class T> Vector<3, T> operator*(const Matrix3<T> &m, const Vector<3, T> &v) { return m.a * v.x + m.b * v.y + m.c * v.z; }
template <class T> Matrix3<T> operator*(const Matrix3<T> &m, const Matrix3<T> &n) { return {m * n.a, m * n.b, m * n.c}; }
template <class T> Matrix3<T> transpose(const Matrix3<T> &m) {
  return {{m.a.x, m.b.x, m.c.x}, {m.a.y, m.b.y, m.c.y}, {m.a.z, m.b.z, m.c.z}};
}
template <class T> T determinant(const Matrix3<T> &m) { return dot(m.a, cross(m.b, m.c)); }
template <class T> Matrix3<T> inverse(const Matrix3<T> &m) {
  return transpose(Matrix3<T>(cross(m.b, m.c), cross(m.c, m.a), cross(m.a, m.b))) / determinant(m);
}

} // namespace KERNEL_TARGET
} // namespace paradesc::kernels
