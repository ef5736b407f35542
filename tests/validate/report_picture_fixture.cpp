#include <algorithm>
#include <array>
#include <cmath>
#include <string_view>

#include "tests/validate/report_sample.h"

namespace backbend::validate {
namespace {

constexpr int kWidth = 480, kHeight = 270;
using Image = std::vector<std::uint8_t>;  // grey, row by row
using Bytes = std::vector<std::uint8_t>;

void big_endian(Bytes& out, std::uint32_t value) {
  for (int shift = 24; shift >= 0; shift -= 8)
    out.push_back(static_cast<std::uint8_t>(value >> shift));
}

std::uint32_t crc32(const Bytes& bytes, std::size_t from) {
  std::uint32_t crc = ~0u;
  for (std::size_t i = from; i < bytes.size(); ++i) {
    crc ^= bytes[i];
    for (int bit = 0; bit < 8; ++bit) crc = crc >> 1 ^ (crc & 1 ? 0xedb88320u : 0);
  }
  return ~crc;
}

void chunk(Bytes& png, std::string_view type, const Bytes& data) {
  big_endian(png, static_cast<std::uint32_t>(data.size()));
  const std::size_t start = png.size();
  png.insert(png.end(), type.begin(), type.end());
  png.insert(png.end(), data.begin(), data.end());
  big_endian(png, crc32(png, start));
}

/// Deflate with the fixed code (RFC 1951, 3.2.6) and no matches but runs of 10 or 258 equal bytes:
/// enough for drawings that are mostly background.
class Deflate {
 public:
  Deflate() { bits(0b011, 3); }
  void add(const Bytes& data) {
    for (std::size_t i = 0; i < data.size();) {
      literal(data[i++]);
      std::size_t run = 0;
      while (i + run < data.size() && run < 258 && data[i + run] == data[i - 1]) ++run;
      if (run < 10) continue;
      run = run < 258 ? 10 : 258;
      run == 258 ? code(0xc5, 8) : code(8, 7);
      code(0, 5);  // distance 1
      i += run;
    }
  }
  Bytes finish() {
    code(0, 7);
    bits(0, 7);
    return out_;
  }

 private:
  void literal(unsigned v) { v < 144 ? code(0x30 + v, 8) : code(0x190 + v - 144, 9); }
  void code(unsigned value, int count) {
    for (int i = count - 1; i >= 0; --i) bits(value >> i & 1u, 1);
  }
  void bits(unsigned value, int count) {
    for (int i = 0; i < count; ++i) {
      pending_ |= (value >> i & 1u) << used_;
      if (++used_ < 8) continue;
      out_.push_back(static_cast<std::uint8_t>(pending_));
      pending_ = 0;
      used_ = 0;
    }
  }
  Bytes out_{0x78, 0x01};
  unsigned pending_ = 0;
  int used_ = 0;
};

Bytes encode_png(const Image& image) {
  Bytes rows;
  for (int y = 0; y < kHeight; ++y) {
    rows.push_back(0);
    rows.insert(rows.end(), image.begin() + y * kWidth, image.begin() + (y + 1) * kWidth);
  }
  std::uint32_t a = 1, b = 0;  // Adler-32
  for (const std::uint8_t byte : rows) {
    a = (a + byte) % 65521;
    b = (b + a) % 65521;
  }
  Deflate deflate;
  deflate.add(rows);
  Bytes data = deflate.finish();
  big_endian(data, b << 16 | a);
  Bytes png{0x89, 'P', 'N', 'G', 0x0d, 0x0a, 0x1a, 0x0a}, header;
  big_endian(header, kWidth);
  big_endian(header, kHeight);
  header.insert(header.end(), {8, 0, 0, 0, 0});
  chunk(png, "IHDR", header);
  chunk(png, "IDAT", data);
  chunk(png, "IEND", {});
  return png;
}

struct Ball {
  double x, y, radius;
};

/// A body in profile whose spine is bent by `angle` degrees: balls from the knees to the head.
std::vector<Ball> body(double angle, bool flipped) {
  std::vector<Ball> balls;
  double x = 215, y = 262;
  for (; y > 170; y -= 3) balls.push_back({x, y, 22 + (262 - y) * 0.06});
  double turn = 0;
  for (int i = 0; i < 40; ++i) {
    turn += angle / 40 * 3.14159265 / 180;
    x -= 2.4 * std::sin(turn);
    y -= 2.4 * std::cos(turn);
    balls.push_back({x, y, 27 + 6 * std::sin(i / 40.0 * 3.1)});
  }
  const double side = flipped ? -1 : 1;  // the arm swings to the other side with the top vertebra
  for (int i = 0; i < 26; ++i)
    balls.push_back(
        {x + side * i * 2.6 * std::cos(turn), y + side * i * -2.6 * std::sin(turn) + i, 9});
  for (int i = 0; i < 12; ++i)
    balls.push_back({x - (18 + i) * std::sin(turn), y - (18 + i) * std::cos(turn), 19});
  return balls;
}

Image draw(double angle, bool flipped, bool heat) {
  Image image(static_cast<std::size_t>(kWidth) * kHeight, heat ? 24 : 205);
  std::vector<double> depth(image.size(), -1);
  for (const Ball& ball : body(angle, flipped)) {
    const int r = static_cast<int>(ball.radius) + 1;
    for (int y = static_cast<int>(ball.y) - r; y <= ball.y + r; ++y)
      for (int x = static_cast<int>(ball.x) - r; x <= ball.x + r; ++x) {
        if (x < 0 || y < 0 || x >= kWidth || y >= kHeight) continue;
        const double dx = (x - ball.x) / ball.radius, dy = (y - ball.y) / ball.radius;
        const double z2 = 1 - dx * dx - dy * dy;
        if (z2 <= 0) continue;
        const auto pixel = static_cast<std::size_t>(y * kWidth + x);
        const double z = std::sqrt(z2) * ball.radius;
        if (z <= depth[pixel]) continue;
        depth[pixel] = z;
        const double lit = std::max(0.0, -0.45 * dx - 0.55 * dy + 0.70 * std::sqrt(z2));
        image[pixel] =
            static_cast<std::uint8_t>(heat ? 40 + 190 * (1 - lit) * (y < 150) : 45 + 150 * lit);
      }
  }
  return image;
}

}  // namespace

std::vector<std::uint8_t> sample_picture(const std::string& path) {
  const std::size_t slash = path.rfind('/');
  const int frame = std::atoi(path.c_str() + (slash == std::string::npos ? 0 : slash + 1));
  const int pose = std::max(0, frame - kFirstFrame);
  const bool extension = path.find("extension") != std::string::npos;
  const bool isner = path.find("isner") != std::string::npos;
  const double angle = frame == 0 ? 90 : extension ? pose * 2.0 : (pose - 15) * 1.5;
  return encode_png(draw(isner ? angle * 0.93 : angle, isner && extension && pose > 57,
                         path.starts_with("heat/")));
}

}  // namespace backbend::validate
