# Which files of a library or a test program can be compiled as one unit (CoLiftUnits.cmake): prints "UNIT FILE" for each file.
#   awk -v most_lines=N -f units.awk FILE...
# Two files do not go together when one declares a name for itself (in its anonymous namespace) that occurs in the other.
# What it declares in a namespace that is its own besides (namespace tilt_trials) meets nobody.
# A file that takes all names of an enum into its namespace stays alone. Relies on clang-format: what stands in a namespace
# starts in the first column.

FNR == 1 { files[++count] = FILENAME; own = 0; scope = ""; list = "" }
{ ++lines[count] }
/^namespace [a-z_]+ \{/ && $2 != "colift" { scope = $2; opens[count, scope] = 1 }
/^\}  \/\/ namespace [a-z_]+$/ { if ($4 == scope) scope = "" }
/^namespace \{/ { own = 1; next }
/^\}  \/\/ namespace$/ { own = 0; next }
{
  text = $0
  gsub(/"([^"\\]|\\.)*"/, "\"\"", text)
  sub(/\/\/.*/, "", text)
  # "enum" or "constants" from the line on which such a declaration begins to the one on which it ends
  if (own && text ~ /^(enum |(inline )?const(expr)? )/) list = text ~ /^enum / ? "enum" : "constants"
  if (own && list != "") note_list(text)
  if (text ~ /[;(]/ && list != "") list = ""
  if (text ~ /^using enum/) alone[count] = 1
  else if (text ~ /^using [A-Za-z0-9_:]*;/ || (own && text ~ /^[A-Za-z\[]/)) note(text)
  # every name that occurs; what is looked up in something else (a.b, a->b, a::b) is not the file's own
  while (match(text, /[A-Za-z_][A-Za-z0-9_]*/)) {
    before = RSTART > 1 ? substr(text, RSTART - 1, 1) : ""
    if (before !~ /[.:>"\/<]/) occurs[count, substr(text, RSTART, RLENGTH)] = 1
    text = substr(text, RSTART + RLENGTH)
  }
}

function note(text,  name) {
  sub(/^\[\[[^\]]*\]\] */, "", text)
  # the same alias twice is no contradiction; another one of its name is
  if (text ~ /^(using namespace|static_assert|template|friend|public|private|extern|[A-Z_]*TEST_CASE)/) return
  if (text ~ /^using [A-Za-z0-9_:]*;/) {
    name = text
    sub(/;.*/, "", name)
    sub(/.*[: ]/, "", name)
    alias[count, name] = text
    aliases[count] = aliases[count] " " name
    return
  }
  if (text ~ /^(using|namespace) [A-Za-z0-9_]* =/) {
    split(text, word, " ")
    alias[count, word[2]] = text
    aliases[count] = aliases[count] " " word[2]
    return
  }
  if (text ~ /^(struct|class|enum)/) {
    sub(/^(struct|class|enum class|enum) */, "", text)
  } else {
    sub(/ *[=({\[;].*/, "", text)   # up to the value or the parameters
    sub(/.*[ *&>]/, "", text)
  }
  if (match(text, /^[A-Za-z_][A-Za-z0-9_]*/)) declares[count] = declares[count] " " scope ":" substr(text, RSTART, RLENGTH)
}

# Constants after the first of "constexpr int kA = 1, kB = 2;", and those of an enum, on as many lines as they take.
function note_list(text,  name, one) {
  one = list == "enum" ? "(^ *|[{,] *)k[A-Z][A-Za-z0-9_]*" : "k[A-Z][A-Za-z0-9_]* ="
  while (match(text, one)) {
    name = substr(text, RSTART, RLENGTH)
    gsub(/[^A-Za-z0-9_]/, "", name)
    declares[count] = declares[count] " " scope ":" name
    text = substr(text, RSTART + RLENGTH)
  }
}

function contradict(a, b,  n, i, word, scoped) {
  if (alone[a] || alone[b]) return 1
  n = split(declares[a], word, " ")
  for (i = 1; i <= n; ++i) {
    split(word[i], scoped, ":")  # namespace of the file's own, name
    if ((scoped[1] == "" || (b, scoped[1]) in opens) && (b, scoped[2]) in occurs) return 1
  }
  n = split(aliases[a], word, " ")
  for (i = 1; i <= n; ++i) if ((b, word[i]) in alias && alias[b, word[i]] != alias[a, word[i]]) return 1
  return 0
}

# The files that go with the fewest others choose their unit first: that leaves fewer units.
END {
  for (f = 1; f <= count; ++f)
    for (g = 1; g < f; ++g)
      if (contradict(f, g) || contradict(g, f)) {
        apart[f, g] = apart[g, f] = 1
        ++meets[f]
        ++meets[g]
      }
  for (placed = 1; placed <= count; ++placed) {
    next_file = 0
    for (f = 1; f <= count; ++f)
      if (!(f in has_unit) && (!next_file || meets[f] > meets[next_file])) next_file = f
    f = next_file
    has_unit[f] = 1
    for (u = 1; u <= units; ++u) {
      fits = size[u] + lines[f] <= most_lines
      for (m = 1; fits && m <= members[u]; ++m)
        if ((f, member[u, m]) in apart) fits = 0
      if (fits) break
    }
    if (u > units) units = u
    member[u, ++members[u]] = f
    size[u] += lines[f]
    print u, files[f]
  }
}
