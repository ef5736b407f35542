#include "render/image/cryptomatte.h"

#include <gtest/gtest.h>

#include <bit>
#include <cmath>

namespace backbend::render {
namespace {

// Vectors of the Cryptomatte 1.2.0 specification and of its reference implementation's tests.
TEST(Cryptomatte, HashesNamesAsTheSpecificationDoes) {
  EXPECT_EQ(murmur3("torus"), 4053562365u);
  EXPECT_FLOAT_EQ(cryptomatte_id("torus"), -1.54943624832e+30f);
  EXPECT_FLOAT_EQ(cryptomatte_id("hello"), 6.0705627102400005616e-17f);
  EXPECT_FLOAT_EQ(cryptomatte_id("cube"), -4.08461912519e+15f);
  EXPECT_FLOAT_EQ(cryptomatte_id("sphere"), 2.79018604383e+15f);
  EXPECT_FLOAT_EQ(cryptomatte_id("plane"), 3.66557617593e-11f);
}

TEST(Cryptomatte, HashesUtf8BytesWithTheirTopBitSet) {
  EXPECT_EQ(murmur3("\xd1\x80\xd0\xb0\xd0\xb2\xd0\xbd\xd0\xb8\xd0\xbd\xd0\xb0"), 2518896926u);
  EXPECT_FLOAT_EQ(cryptomatte_id("m\xc3\xa4"
                                 "dchen"),
                  6.2361298211599995797e+25f);
}

// Its hash 8019cdb4 has exponent 0: a denormal, which any step of a pipeline may flush to zero.
TEST(Cryptomatte, TurnsOneExponentBitOfTorso) {
  EXPECT_EQ(murmur3("torso"), 0x8019cdb4u);
  EXPECT_EQ(cryptomatte_bits("torso"), 0x8099cdb4u);
  EXPECT_TRUE(std::isnormal(cryptomatte_id("torso")));
}

TEST(Cryptomatte, WritesTheHeaderKeysThatReadersLookFor) {
  const std::vector<std::string> names{"torso", "arm \"L\"\n"};
  const auto attributes = cryptomatte_attributes("CryptoObject", names);
  ASSERT_EQ(attributes.size(), 4u);
  EXPECT_EQ(attributes[0].name, "cryptomatte/3ae39a5/name");
  EXPECT_EQ(attributes[0].value, "CryptoObject");
  EXPECT_EQ(attributes[1].value, "MurmurHash3_32");
  EXPECT_EQ(attributes[2].value, "uint32_to_float32");
  EXPECT_EQ(attributes[3].name, "cryptomatte/3ae39a5/manifest");
  EXPECT_EQ(attributes[3].value.substr(0, 22),
            "{\"arm \\\"L\\\"\\u000a\":\"" + attributes[3].value.substr(20, 2));
  EXPECT_NE(attributes[3].value.find("\"torso\":\"8099cdb4\""), std::string::npos);
  const std::vector<std::string> one{"x"};
  EXPECT_EQ(cryptomatte_attributes("CryptoAsset", one)[0].name, "cryptomatte/f42029d/name");
}

TEST(Cryptomatte, RanksByCoverageAndDropsTheSeventh) {
  auto layers = cryptomatte_layers("CryptoObject", 2);
  ASSERT_EQ(layers.size(), 3u);
  EXPECT_EQ(layers[2].names[3], "CryptoObject02.a");
  std::vector<Matte> matte;
  const float coverage[7] = {0.1f, 0.25f, 0.05f, 0.2f, 0.2f, 0.15f, 0.02f};
  for (int i = 0; i < 7; ++i) matte.push_back({static_cast<float>(i + 1), coverage[i]});
  write_cryptomatte(layers, 1, matte);
  const float expected_id[6] = {2, 4, 5, 6, 1, 3};  // of the two equal ones the first comes first
  for (int rank = 0; rank < 6; ++rank) {
    EXPECT_EQ(layers[rank / 2].data[4 + rank % 2 * 2], expected_id[rank]) << rank;
    EXPECT_EQ(layers[rank / 2].data[rank % 2 * 2], 0.0f) << "the other pixel stays empty";
  }
}

}  // namespace
}  // namespace backbend::render
