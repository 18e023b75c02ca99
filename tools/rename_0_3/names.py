"""Hand-written rules: what an identifier is called from 0.3 on. Used by rename.py; throwaway."""
import re

# ---- whole identifiers, everywhere in C++ (and, where they occur there, in Python names and in code words of texts)
EXACT = {}
def table(text):
    for line in text.strip().splitlines():
        line = line.split('#')[0].strip()
        if line:
            old, new = line.split()
            EXACT[old] = new

table('''
Drive InputSequence
DriveStep InputStep
DriveSample InputSample
DriveMemory InputMemory
DriveMode PredictionMode
fullDrive inputSequence
compressedDrive compressedInputs
CompressedDrive CompressedInputs
FullDrive FullInputs
driveStep inputStep
driveOf inputsOf
DriveOf InputsOf
exactDrive exactInputs
row_drive_ row_inputs_
drive_ inputs_
imposes_voltage voltage_controlled
imposesVoltage isVoltageControlled
voltage_drives voltage_controlled
voltage_drives_ voltage_controlled_
voltageDrives isVoltageControlled
Imposed ControlMode
imposed controlled
imposed_ controlled_
voltage_imposed voltage_controlled
voltage_is_imposed voltage_is_controlled
imposedBy controlModeOf
ImposedTotals ControlModeTotals
ImposedTime ControlledTime
imposedKey operatingModeKey
imposedJson operatingModeJson
imposedBands operatingModeBands
imposedCourse controlledCourse
kLeastImposed kMinControlled
Source ControlModes
SourceWatch ControlModeDetector
findSource detectControlMode
FindSource DetectControlMode
SourceRule ControlModeRule
SourceReason ControlModeReason
SourceStretch ControlModeStretch
SourceOverview ControlModeOverview
SourceShare ChargerShare
source_share charger_share
source_seen charger_present
source_took_over charger_took_over
source_drives voltage_controlled
drivingSource chargerControl
DrivingSource ChargerControl
driving_source charger_control
LearnedForce DiscrepancyModel
LearnedResidual ResidualRegression
learnResidual fitResidualRegression
LearnResidual FitResidualRegression
LearnedFinding DiscrepancyFinding
LearnedEffect DiscrepancyEffect
kLearnedEffect kDiscrepancyEffect
learnedInfo discrepancyInfo
Learned EstimatedDiscrepancy
beyond_learned beyond_identified
beyondLearned beyondIdentified
setBeyondLearned setBeyondIdentified
beyondLearnedAfter beyondIdentifiedAfter
kLearnedReach kDiscrepancyReach
useOfLearned useOfDiscrepancy
is_learned has_discrepancy
learnForce fitDiscrepancy
LearnForce FitDiscrepancy
learnFrom updateFrom
learnFromWindow followWindow
LearnFromWindow FollowWindow
learnRest estimateDiscrepancy
leftToLearn unexplainedPart
learnBeside fitWithDiscrepancy
learn fitPart
ForceKind RegressorKind
ForceColumn Regressor
ForceColumns Regressors
forceLibrary regressorLibrary
ForceLibrary RegressorLibrary
ForceTable DesignMatrix
forceTable designMatrix
ForceGroup RegressorGroup
kForceGroups kRegressorGroups
ForceMemory RegressorMemory
forceMemory regressorMemory
force_memory regressor_memory
firstForceMemory firstRegressorMemory
ForceContext RegressorContext
ForceMoment RegressorInput
ForceMomentOf RegressorInputOf
allForceKinds allRegressorKinds
ForceFit DiscrepancyFit
ForceRun DiscrepancyRun
madeForce madeDiscrepancyModel
madeForceModel madeModelWithDiscrepancy
ColumnFilter RegressorFilter
Discrepancy ResidualState
discrepancy residual_state
discrepancyOf residualStateOf
kDiscrepancy kCatalogueTolerance
BaseResponse Linearization
baseResponse linearizationOf
Experience EventHistory
experience event_history
readExperience readEventHistory
experienceNode eventHistoryNode
experiencedCrank correctCrankPrediction
ExperiencedCrank CorrectCrankPrediction
experiencedCharge correctChargePrediction
ExperiencedCharge CorrectChargePrediction
NaiveContest BaselineSelector
NaiveContestEvent BaselineSelectorEvent
NaiveStanding BaselineSelection
NaiveStandings BaselineSelections
naive_answers baseline_selected
naive_answers_ baseline_selected_
naive_answered baseline_answered
doesNaiveAnswer isBaselineSelected
setBesideNaive compareWithBaseline
Contest ModelSelector
ContestScore ModelSelectorScore
contest selector
contestSentence selectorSentence
fillContest fillSelector
ErrorTracker ResidualFilter
IntervalScale IntervalCalibration
setScales setCalibrations
observe update
scaleNode calibrationNode
LiveModel ModelSnapshot
TrackedModel ModelMonitor
tracked monitor
kTracked kMonitored
Absorption ParameterBias
absorption parameter_bias
absorbed_into biased_parameters
absorbedInto biasedParameters
absorbed biased
absorptionMap parameterBiases
AbsorptionMap ParameterBiases
Detectable DetectionLimit
detectable detection_limits
detectableOf detectionLimitsOf
detectableTable detectionLimitsTable
detectableJson detectionLimitJson
lists_detectable lists_detection_limits
madeDetectable madeDetectionLimit
LeastStrength LinearDetectionLimit
hiddenText detectionLimitsText
hiddenSection detectionLimitsSection
hiddenBy isHiddenBy
Explainer StepwiseSelection
explainer selection
Component SelectedTerm
components terms
most_components max_terms
LeftOver UnexplainedPart
left_rms unexplained_rms
left_crank unexplained_crank
left_charge_share unexplained_charge_share
left_family unexplained_mechanism
left_rmse unexplained_rmse
tied_with indistinguishable_from
tied indistinguishable
EdgeNoise TimingJitterNoise
edgeNoise timingJitterNoise
temper effective_sample_fraction
temper_ effective_sample_fraction_
takeTemper takeEffectiveSampleFraction
kFirstTemper kFirstSampleFraction
kLeastTemper kMinSampleFraction
kSettledTemper kSettledSampleFraction
kTemperPasses kSampleFractionPasses
bends is_nonlinear
wander random_walk
most_wander_ max_random_walk_
sentence format
listed join
describe toString
inside_share coverage
insideShare coverageOf
weighs_cranks includes_cranks
kVouchingVoltage kSupportVoltage
kVouchingShare kSupportShare
kVouchingCurrent kSupportCurrent
predictionSuitability windowQuality
WindowSuitability WindowQuality
suitabilityOf windowQualityOf
isRowOfBlocks areSeriesBlocks
kRowsOfBlocks kAllowedSeriesBlocks
kFewestBlocks kMinSeriesBlocks
kMostBlocks kMaxSeriesBlocks
sentenceOfRow seriesBlocksSentence
blocksInSeries seriesBlocksAt
inRow ofSeries
ofOneBlock perBlock
addBlocksOption addSeriesBlocksOption
BlocksOption SeriesBlocksOption
RowOfBlocks SeriesBlocks
adopt_diagnosis use_diagnosis
learnt estimated
vouches is_supported
Standing SimulationState
ModelPlace ModelPosition
StrangerForce OutOfModelVoltage
AddedForces AddedVoltages
drawStranger drawOutOfModel
''')

# ---- phrases of words inside longer identifiers, everywhere in C++
PHRASES = [tuple(tuple(side.split()) for side in line.split('->')) for line in '''
naive -> baseline
family -> mechanism
families -> mechanisms
crank scale -> crank calibration
charge scale -> charge calibration
suitability -> window quality
detectable -> detection limit
absorption -> parameter bias
wander -> random walk
strangers -> out of model
stranger -> out of model
learned -> discrepancy
tracked -> monitored
contest -> selector
tied -> indistinguishable
experience -> event history
'''.strip().splitlines()]
FORCE = [(('force',), ('discrepancy',)), (('forces',), ('discrepancies',))]

# identifiers that stay, whatever the rules say
KEEP = set('''force_update EqualsABruteForceSimulation contest_duration byBruteForce kAtLeast isAtLeastTwice leastOf mostOf least most kLeast kMost kMost_
mostInward Families_'''.split())

def words_of(identifier):
    core = identifier.strip('_')
    out = []
    for part in core.split('_'):
        out += re.findall(r'[A-Z]+(?=[A-Z][a-z])|[A-Z]?[a-z0-9]+|[A-Z]+[0-9]*', part)
    return out

def joined(words, like):
    lead = re.match(r'_*', like).group(0)
    trail = '_' if like.endswith('_') else ''
    core = like.strip('_')
    low = [w.lower() for w in words]
    if '_' in core or (core.islower() and core[0].islower()):
        return lead + '_'.join(low) + trail
    cap = [w[0].upper() + w[1:] for w in low]
    if core[0].islower():
        cap[0] = low[0]
    return lead + ''.join(cap) + trail

def by_phrases(identifier, phrases):
    words = words_of(identifier)
    if ''.join(words) != identifier.replace('_', ''):
        return identifier
    if re.search(r'[A-Z]_|_[A-Z]', identifier) or identifier.isupper():
        return identifier
    low = [w.lower() for w in words]
    out, changed, n = [], False, 0
    while n < len(low):
        for old, new in phrases:
            if tuple(low[n:n + len(old)]) == old:
                out += new
                n += len(old)
                changed = True
                break
        else:
            out.append(low[n])
            n += 1
    return joined(out, identifier) if changed else identifier

def least_most(identifier):
    m = re.match(r'(k?)(least|most|Least|Most)(_(?=[a-z])|(?=[A-Z]))(.+)$', identifier)
    if not m:
        return identifier
    word = {'least': 'min', 'most': 'max'}[m.group(2).lower()]
    if m.group(2)[0].isupper():
        word = word.capitalize()
        if not m.group(1):
            return identifier
    return m.group(1) + word + m.group(3) + m.group(4)

def is_sentence(identifier):
    return identifier[:1].isupper() and '_' not in identifier and len(words_of(identifier)) >= 6

def renamed(identifier, local, phrases):
    """New name of an identifier. local: names of this file alone; they go first."""
    if identifier in local:
        return local[identifier]
    if identifier in KEEP or is_sentence(identifier):
        return identifier
    if identifier in EXACT:
        return EXACT[identifier]
    if identifier.endswith('_') and identifier[:-1] in EXACT and not identifier.endswith('__'):
        return EXACT[identifier[:-1]] + '_'
    return least_most(by_phrases(identifier, phrases))
