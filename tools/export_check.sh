#!/bin/sh
# Every exported kernel through the languages' own checkers: SPIR-V through spirv-val, GLSL through
# glslangValidator, which links it too (a file without an entry point is valid until then). GOBO may name the program.
set -eu

say() { printf 'export-check: %s\n' "$*" >&2; }

gobo=${GOBO:-target/release/gobo}
missing=
command -v spirv-val >/dev/null 2>&1 || missing="$missing spirv-tools"
command -v glslangValidator >/dev/null 2>&1 || missing="$missing glslang-tools"
if [ -n "$missing" ]; then
    if ! command -v apt-get >/dev/null 2>&1; then
        say "install spirv-val and glslangValidator (the Vulkan SDK has both)"
        exit 1
    fi
    as_root=
    if [ "$(id -u)" -ne 0 ]; then
        as_root=sudo
    fi
    say "installing$missing"
    # shellcheck disable=SC2086 # a list of words
    {
        $as_root apt-get update -qq
        $as_root env DEBIAN_FRONTEND=noninteractive apt-get install -y -qq $missing
    } >&2
fi

folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
for target in spirv glsl; do
    "$gobo" export --target "$target" -o "$folder/$target" >/dev/null
done

refused=0
checked=0
check() { # file command...
    file=$1
    shift
    checked=$((checked + 1))
    if ! "$@" "$file" >"$folder/log" 2>&1; then
        refused=$((refused + 1))
        echo "$(basename "$file"): REFUSED"
        cat "$folder/log"
    fi
}
# The linker must find what the parser does not.
printf '#version 450\nlayout(local_size_x = 1) in;\n' >"$folder/headless.comp"
if glslangValidator -l -S comp "$folder/headless.comp" >/dev/null 2>&1; then
    say "glslangValidator takes a shader without an entry point"
    exit 1
fi
for file in "$folder"/spirv/*.spv; do
    check "$file" spirv-val --target-env vulkan1.1
done
for file in "$folder"/glsl/*.comp; do
    check "$file" glslangValidator -l -S comp
done
# The look-ups of light, as a shader that calls them.
for file in "$folder"/glsl/*.glsl; do
    whole=$folder/$(basename "$file" .glsl).comp
    {
        printf '#version 450\n#define GOBO_PROBE\nlayout(local_size_x = 1) in;\n'
        cat "$file"
    } >"$whole"
    check "$whole" glslangValidator -l -S comp
done
echo "export-check: $((checked - refused)) of $checked files are valid"
[ "$checked" -gt 0 ] && [ "$refused" -eq 0 ]
