#!/usr/bin/env python3
"""Checks what tools/dds/ros2 has for a machine with ROS 2, as far as Debian can.

    ros2_sources_test.py ROOT

Messages have the names, types and order of members of the IDL that the program is built from; XML and YAML are well-formed;
the CMake file is read by CMake with the commands of ament replaced, and names every message.
"""
import pathlib, re, subprocess, sys, tempfile
import xml.etree.ElementTree as xml

ROOT = pathlib.Path(sys.argv[1])
ROS2 = ROOT / "tools/dds/ros2"
TYPES = {"boolean": "bool", "octet": "uint8", "long": "int32", "unsigned long": "uint32",
         "unsigned long long": "uint64", "float": "float32", "double": "float64", "string": "string"}
STUBS = """
function(project name)
  set(PROJECT_NAME ${name} PARENT_SCOPE)
endfunction()
function(find_package)
endfunction()
function(ament_export_dependencies)
endfunction()
function(ament_package)
  message(STATUS "packed")
endfunction()
function(rosidl_generate_interfaces target)
  cmake_parse_arguments(ARG "" "" "DEPENDENCIES" ${ARGN})
  foreach(file ${ARG_UNPARSED_ARGUMENTS})
    if(NOT EXISTS ${FOLDER}/${file})
      message(FATAL_ERROR "no ${file}")
    endif()
    message(STATUS "message ${file}")
  endforeach()
endfunction()
include(${FOLDER}/CMakeLists.txt)
"""


def of_idl(text):
    """Members of each struct of colift_msgs: [(type as in a .msg, name)]."""
    found = {}
    text = re.sub(r"//.*", "", text)
    for name, body in re.findall(r"struct (\w+)_ \{(.*?)\};", text, re.S):
        members = []
        for kind, member in re.findall(r"\s*([\w:<> ]+?)\s+(\w+);", body):
            array = re.match(r"sequence<(.*)>$", kind)
            kind = array.group(1) if array else kind
            ros = re.match(r"(\w+)::msg::dds_::(\w+)_$", kind)
            kind = f"{ros.group(1)}/{ros.group(2)}" if ros else TYPES.get(kind) or kind.removesuffix("_")
            members.append((kind + ("[]" if array else ""), member))
        found[name] = members
    return found


def of_msg(text):
    lines = (line.split("#")[0].split() for line in text.splitlines())
    return [tuple(line) for line in lines if line]


def main():
    package = ROS2 / "colift_msgs"
    idl = of_idl((ROOT / "hal/dds/idl/colift_messages.idl").read_text())
    messages = {file.stem: of_msg(file.read_text()) for file in sorted((package / "msg").glob("*.msg"))}
    assert sorted(idl) == sorted(messages), f"{sorted(idl)} in the IDL, {sorted(messages)} as .msg"
    for name, members in messages.items():
        assert members == idl[name], f"{name}: {members} as .msg, {idl[name]} in the IDL"
    assert xml.parse(package / "package.xml").getroot().findtext("name") == "colift_msgs"
    assert xml.parse(ROS2 / "view/colift.launch.xml").getroot().tag == "launch"
    with tempfile.TemporaryDirectory() as folder:
        script = pathlib.Path(folder) / "read.cmake"
        script.write_text(STUBS)
        done = subprocess.run(["cmake", f"-DFOLDER={package}", "-P", script], capture_output=True, text=True)
    assert done.returncode == 0 and "packed" in done.stdout + done.stderr, done.stderr
    named = sorted(re.findall(r"message msg/(\w+)\.msg", done.stdout + done.stderr))
    assert named == sorted(messages), f"CMake names {named}"
    try:
        import yaml
        layout = yaml.safe_load((ROS2 / "view/colift.rviz").read_text())
        shown = re.findall(r"'(/[\w/]+)'", str(layout))
    except ImportError:
        shown = re.findall(r"Value: (/[\w/]+)", (ROS2 / "view/colift.rviz").read_text())
    published = "".join((ROOT / "tools/dds" / name).read_text() for name in ("outlets.cpp", "ros2_publisher.cpp"))
    for topic in shown:
        assert f'"{topic}"' in published, f"the layout shows {topic}, which nobody publishes"
    print(f"{len(messages)} messages, {len(shown)} topics: all agree")


main()
