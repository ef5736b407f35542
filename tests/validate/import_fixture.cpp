#include "tests/validate/import_fixture.h"

#include <array>
#include <sstream>
#include <vector>

namespace backbend::validate {
namespace {

constexpr int kJoints = 4;

std::string list(const std::vector<double>& values, const char* between) {
  std::ostringstream out;
  out.precision(12);  // FBX counts 46 186 158 000 ticks a second
  for (std::size_t i = 0; i < values.size(); ++i) out << (i ? between : "") << values[i];
  return out.str();
}

/// A point or direction of the tower (Y up, metres) in the file's axes and unit.
std::array<double, 3> in_file(const TowerFile& file, double x, double y, double z) {
  const double s = 1.0 / file.metres_per_unit;
  return file.z_up ? std::array<double, 3>{x * s, -z * s, y * s}
                   : std::array<double, 3>{x * s, y * s, z * s};
}

std::vector<double> vertices(const TowerFile& file) {
  std::vector<double> out;
  for (int ring = 0; ring < kJoints; ++ring)
    for (int corner = 0; corner < 4; ++corner) {
      const double x = corner == 0 || corner == 3 ? -0.05 : 0.05, z = corner < 2 ? 0.05 : -0.05;
      for (const double v : in_file(file, x, 0.2 * ring, z)) out.push_back(v);
    }
  return out;
}

/// Four sides of each storey, quads wound outwards.
std::vector<std::array<int, 4>> quads() {
  std::vector<std::array<int, 4>> out;
  for (int ring = 0; ring + 1 < kJoints; ++ring)
    for (int side = 0; side < 4; ++side) {
      const int low = 4 * ring + side, next = 4 * ring + (side + 1) % 4;
      out.push_back({low, next, next + 4, low + 4});
    }
  return out;
}

/// Row by row: the place of joint k in a tower that stands at `x` (`sign` 1) or the way back (-1).
std::vector<double> translation_rows(const TowerFile& file, double x, int k, double sign) {
  const auto t = in_file(file, x, 0.2 * k, 0.0);
  return {1, 0, 0, sign * t[0], 0, 1, 0, sign * t[1], 0, 0, 1, sign * t[2], 0, 0, 0, 1};
}

std::vector<double> transposed(const std::vector<double>& m) {
  std::vector<double> out(16);
  for (std::size_t r = 0; r < 4; ++r)
    for (std::size_t c = 0; c < 4; ++c) out[4 * c + r] = m[4 * r + c];
  return out;
}

}  // namespace

std::string tower_fbx(const TowerFile& file) {
  std::ostringstream out;
  out << "; FBX 7.4.0 project file\nFBXHeaderExtension:  {\n FBXHeaderVersion: 1003\n FBXVersion: "
         "7400\n}\nGlobalSettings:  {\n Version: 1000\n Properties70:  {\n";
  const auto number = [&](const char* name, const char* type, double value) {
    out << "  P: \"" << name << "\", \"" << type << "\", \""
        << (type == std::string("int") ? "Integer" : "Number") << "\", \"\"," << value << "\n";
  };
  number("UpAxis", "int", file.z_up ? 2 : 1);
  number("UpAxisSign", "int", 1);
  number("FrontAxis", "int", file.z_up ? 1 : 2);
  number("FrontAxisSign", "int", file.z_up ? -1 : 1);
  number("CoordAxis", "int", 0);
  number("CoordAxisSign", "int", 1);
  number("UnitScaleFactor", "double", 100.0 * file.metres_per_unit);
  out << " }\n}\nObjects:  {\n";

  std::vector<double> corners;
  for (const auto& quad : quads())
    for (std::size_t k = 0; k < 4; ++k) corners.push_back(k < 3 ? quad[k] : -quad[k] - 1);
  const std::vector<double> position = vertices(file);
  const auto array = [&](const char* name, const std::vector<double>& values) {
    out << "  " << name << ": *" << values.size() << " {\n   a: " << list(values, ",") << "\n  }\n";
  };
  if (file.more > 0) out << " Model: 600, \"Model::towers\", \"Null\" {\n  Version: 232\n }\n";
  const auto place = [&](const std::array<double, 3>& t) {
    out << "  Properties70:  {\n   P: \"Lcl Translation\", \"Lcl Translation\", \"\", \"A\","
        << list({t[0], t[1], t[2]}, ",") << "\n  }\n";
  };
  for (int n = 0; n <= file.more; ++n) {
    const int id = 1000 * n;
    out << " Geometry: " << 100 + id << ", \"Geometry::tower\", \"Mesh\" {\n";
    array("Vertices", position);
    array("PolygonVertexIndex", corners);
    out << "  GeometryVersion: 124\n }\n Model: " << 200 + id
        << ", \"Model::tower\", \"Mesh\" {\n  Version: 232\n";
    place(in_file(file, n, 0.0, 0.0));
    out << " }\n";
    for (int k = 0; k < kJoints; ++k) {
      out << " NodeAttribute: " << 350 + k + id << ", \"NodeAttribute::" << file.name << k
          << "\", \"LimbNode\" {\n  TypeFlags: \"Skeleton\"\n }\n Model: " << 300 + k + id
          << ", \"Model::" << file.name << k << "\", \"LimbNode\" {\n  Version: 232\n";
      place(in_file(file, k == 0 ? n : 0.0, k == 0 ? 0.0 : 0.2, 0.0));
      out << " }\n";
    }
    out << " Deformer: " << 400 + id << ", \"Deformer::\", \"Skin\" {\n  Version: 101\n }\n";
    for (int k = 0; k < kJoints; ++k) {
      out << " Deformer: " << 410 + k + id
          << ", \"SubDeformer::\", \"Cluster\" {\n  Version: 100\n";
      array("Indexes", {4.0 * k, 4.0 * k + 1, 4.0 * k + 2, 4.0 * k + 3});
      array("Weights", std::vector<double>(4, file.weight));
      array("Transform", transposed(translation_rows(file, 0, k, -1.0)));
      array("TransformLink", transposed(translation_rows(file, n, k, 1.0)));
      out << " }\n";
    }
  }
  out << " AnimationStack: 500, \"AnimStack::bend\", \"\" {\n }\n AnimationLayer: 501, "
         "\"AnimLayer::base\", \"\" {\n }\n AnimationCurveNode: 502, \"AnimCurveNode::R\", \"\" {\n"
         "  Properties70:  {\n   P: \"d|X\", \"Number\", \"\", \"A\",0\n  }\n }\n AnimationCurve: "
         "503, \"AnimCurve::\", \"\" {\n  Default: 0\n  KeyVer: 4008\n";
  array("KeyTime", {0, 46186158000.0});
  array("KeyValueFloat", {0, 90});
  out << " }\n}\nConnections:  {\n";
  const auto connect = [&](int from, int to) { out << " C: \"OO\"," << from << "," << to << "\n"; };
  const int top = file.more > 0 ? 600 : 0;
  if (top > 0) connect(top, 0);
  for (int n = 0; n <= file.more; ++n) {
    const int id = 1000 * n;
    connect(200 + id, top);
    connect(300 + id, top);
    connect(100 + id, 200 + id);
    connect(400 + id, 100 + id);
    for (int k = 0; k < kJoints; ++k) {
      connect(350 + k + id, 300 + k + id);
      if (k > 0) connect(300 + k + id, 300 + k - 1 + id);
      connect(410 + k + id, 400 + id);
      connect(300 + k + id, 410 + k + id);
    }
  }
  connect(501, 500);
  connect(502, 501);
  out << " C: \"OP\",502,301, \"Lcl Rotation\"\n C: \"OP\",503,502, \"d|X\"\n}\n";
  return out.str();
}

std::string tower_dae(const TowerFile& file) {
  std::ostringstream out;
  const auto source = [&](const std::string& id, const std::vector<double>& values, int stride,
                          const std::string& parameters) {
    out << "<source id=\"" << id << "\"><float_array id=\"" << id << "-a\" count=\""
        << values.size() << "\">" << list(values, " ")
        << "</float_array><technique_common><accessor source=\"#" << id << "-a\" count=\""
        << values.size() / static_cast<std::size_t>(stride) << "\" stride=\"" << stride << "\">"
        << parameters << "</accessor></technique_common></source>\n";
  };
  const auto names = [&](const std::string& id, const std::string& words, int count,
                         const char* parameter) {
    out << "<source id=\"" << id << "\"><Name_array id=\"" << id << "-a\" count=\"" << count
        << "\">" << words << "</Name_array><technique_common><accessor source=\"#" << id
        << "-a\" count=\"" << count << "\" stride=\"1\"><param name=\"" << parameter
        << "\" type=\"name\"/></accessor></technique_common></source>\n";
  };
  const std::string xyz =
      "<param name=\"X\" type=\"float\"/><param name=\"Y\" type=\"float\"/><param name=\"Z\" "
      "type=\"float\"/>";
  out << "<?xml version=\"1.0\" encoding=\"utf-8\"?>\n<COLLADA "
         "xmlns=\"http://www.collada.org/2005/11/COLLADASchema\" version=\"1.4.1\">\n<asset><unit "
         "name=\"unit\" meter=\""
      << file.metres_per_unit << "\"/><up_axis>" << (file.z_up ? "Z_UP" : "Y_UP")
      << "</up_axis></asset>\n<library_geometries><geometry id=\"tower\" name=\"tower\"><mesh>\n";
  source("tower-p", vertices(file), 3, xyz);
  out << "<vertices id=\"tower-v\"><input semantic=\"POSITION\" source=\"#tower-p\"/></vertices>\n"
         "<polylist count=\""
      << quads().size()
      << "\"><input semantic=\"VERTEX\" source=\"#tower-v\" offset=\"0\"/><vcount>";
  for (std::size_t q = 0; q < quads().size(); ++q) out << "4 ";
  out << "</vcount><p>";
  for (const auto& quad : quads())
    for (const int corner : quad) out << corner << " ";
  out << "</p></polylist></mesh></geometry></library_geometries>\n<library_controllers><controller "
         "id=\"skin\"><skin source=\"#tower\"><bind_shape_matrix>1 0 0 0 0 1 0 0 0 0 1 0 0 0 0 "
         "1</bind_shape_matrix>\n";
  std::string joints;
  std::vector<double> binds;
  for (int k = 0; k < kJoints; ++k) {
    joints += (k ? " " : "") + file.name + std::to_string(k);
    for (const double v : translation_rows(file, 0, k, -1.0)) binds.push_back(v);
  }
  names("skin-j", joints, kJoints, "JOINT");
  source("skin-b", binds, 16, "<param name=\"TRANSFORM\" type=\"float4x4\"/>");
  source("skin-w", {file.weight}, 1, "<param name=\"WEIGHT\" type=\"float\"/>");
  out << "<joints><input semantic=\"JOINT\" source=\"#skin-j\"/><input "
         "semantic=\"INV_BIND_MATRIX\" source=\"#skin-b\"/></joints><vertex_weights count=\""
      << 4 * kJoints
      << "\"><input semantic=\"JOINT\" source=\"#skin-j\" offset=\"0\"/><input "
         "semantic=\"WEIGHT\" source=\"#skin-w\" offset=\"1\"/><vcount>";
  for (int v = 0; v < 4 * kJoints; ++v) out << "1 ";
  out << "</vcount><v>";
  for (int v = 0; v < 4 * kJoints; ++v) out << v / 4 << " 0 ";
  out << "</v></vertex_weights></skin></controller></library_controllers>\n<library_animations>"
         "<animation id=\"bend\" name=\"bend\">\n";
  source("bend-t", {0, 1}, 1, "<param name=\"TIME\" type=\"float\"/>");
  source("bend-r", {0, 90}, 1, "<param name=\"ANGLE\" type=\"float\"/>");
  names("bend-i", "LINEAR LINEAR", 2, "INTERPOLATION");
  out << "<sampler id=\"bend-s\"><input semantic=\"INPUT\" source=\"#bend-t\"/><input "
         "semantic=\"OUTPUT\" source=\"#bend-r\"/><input semantic=\"INTERPOLATION\" "
         "source=\"#bend-i\"/></sampler><channel source=\"#bend-s\" target=\""
      << file.name
      << "1/turn.ANGLE\"/></animation></library_animations>\n<library_visual_scenes>"
         "<visual_scene id=\"scene\">\n";
  for (int k = 0; k < kJoints; ++k) {
    const auto t = in_file(file, 0.0, k == 0 ? 0.0 : 0.2, 0.0);
    const std::string name = file.name + std::to_string(k);
    out << "<node id=\"" << name << "\" sid=\"" << name << "\" name=\"" << name
        << "\" type=\"JOINT\"><translate sid=\"place\">" << list({t[0], t[1], t[2]}, " ")
        << "</translate><rotate sid=\"turn\">1 0 0 0</rotate>\n";
  }
  for (int k = 0; k < kJoints; ++k) out << "</node>";
  out << "<node id=\"body\" name=\"body\"><instance_controller url=\"#skin\"><skeleton>#"
      << file.name
      << "0</skeleton></instance_controller></node>\n</visual_scene>"
         "</library_visual_scenes><scene><instance_visual_scene "
         "url=\"#scene\"/></scene></COLLADA>\n";
  return out.str();
}

std::string tower_bvh() {
  return "HIERARCHY\nROOT j0\n{\n OFFSET 0 0 0\n CHANNELS 6 Xposition Yposition Zposition "
         "Zrotation "
         "Yrotation Xrotation\n JOINT j1\n {\n  OFFSET 0 1 0\n  CHANNELS 3 Zrotation Yrotation "
         "Xrotation\n  JOINT j2\n  {\n   OFFSET 0 1 0\n   CHANNELS 3 Zrotation Yrotation "
         "Xrotation\n   JOINT j3\n   {\n    OFFSET 0 1 0\n    CHANNELS 3 Zrotation Yrotation "
         "Xrotation\n    End Site\n    {\n     OFFSET 0 0.5 0\n    }\n   }\n  }\n }\n}\nMOTION\n"
         "Frames: 3\nFrame Time: 0.5\n"
         "0 0 0 0 0 0 0 0 0 0 0 0 0 0 0\n"
         "0 0 0 0 0 0 0 0 45 0 0 0 0 0 0\n"
         "0 0 0 0 0 0 0 0 90 0 0 0 0 0 0\n";
}

}  // namespace backbend::validate
